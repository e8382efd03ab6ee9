"""The page on which a gamepad steers: a bar of its own above the live page.

Viser's page runs no script of ours, but browsers tell a gamepad's state to scripts only. So this
page is served beside it, shows it in a frame, and sends what the gamepad does over its own socket.
"""

from __future__ import annotations

GAMEPAD_HTML = """\
<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>Steer by gamepad</title>
<style>
  html, body { height: 100%; margin: 0; font: 14px sans-serif; color: #1f2937; }
  body { display: flex; flex-direction: column; }
  #bar { display: flex; flex-wrap: wrap; gap: 6px 10px; align-items: center; padding: 6px 10px;
         border-bottom: 1px solid #d1d5db; }
  #bar input { width: 9em; font: inherit; padding: 2px 4px; }
  #bar button { font: inherit; padding: 2px 10px; border: 1px solid #2563eb; border-radius: 4px;
                background: #fff; color: #1d4ed8; }
  #bar button[aria-pressed=true] { background: #2563eb; color: #fff; }
  #pad.wrong, #said.wrong { color: #b91c1c; font-weight: bold; }
  summary { cursor: pointer; color: #1d4ed8; }
  td { padding: 0 12px 0 0; }
  iframe { flex: 1; border: 0; width: 100%; }
</style>
</head>
<body>
<div id="bar">
  <label>Your name <input id="name" maxlength="40"></label>
  <span id="robots"></span>
  <span id="pad" role="status">Connect a gamepad and press one of its buttons.</span>
  <span id="said" role="status"></span>
  <details><summary>Sticks and buttons</summary><table>
    <tr><td>left stick</td><td>forwards, backwards, left, right</td></tr>
    <tr><td>right stick</td><td>turn; up and down</td></tr>
    <tr><td>direction pad</td><td>tilt</td></tr>
    <tr><td>A, or the lowest of the four</td><td>open or close the gripper</td></tr>
    <tr><td>Start</td><td>begin</td></tr>
    <tr><td>Y, or the highest of the four</td><td>keep</td></tr>
    <tr><td>Select or Back</td><td>discard and try again</td></tr>
  </table></details>
</div>
<iframe src="/" title="The live page"></iframe>
<script>
"use strict";
const PERIOD_MS = 40, DEAD = 0.15;
const BUTTONS = {0: "grip", 9: "begin", 3: "keep", 8: "again"};
const byId = (id) => document.getElementById(id);
const [pad, said, robots, nameField] = ["pad", "said", "robots", "name"].map(byId);
let socket = null, steered = "", had = "", pressed = new Set();

function say(where, words, wrong) {
  where.textContent = words;
  where.className = wrong ? "wrong" : "";
}

function send(message) {
  if (socket !== null && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
}

function show(names) {
  const buttons = names.map((robot) => {
    const button = document.createElement("button");
    button.textContent = robot;
    button.setAttribute("aria-pressed", String(robot === steered));
    button.onclick = () => send({take: robot, name: nameField.value});
    return button;
  });
  robots.replaceChildren(...buttons);
}

function connect() {
  const scheme = location.protocol === "https:" ? "wss:" : "ws:";
  socket = new WebSocket(scheme + "//" + location.host + "/gamepad/socket");
  socket.onmessage = (event) => {
    const told = JSON.parse(event.data);
    steered = told.robot;
    show(told.robots);
    say(said, told.said, told.wrong);
  };
  socket.onclose = () => {
    say(said, "There is no connection to taskbuilder view; trying again.", true);
    setTimeout(connect, 1000);
  };
}

function found() {
  for (const each of navigator.getGamepads()) if (each && each.connected) return each;
  return null;
}

function axis(gamepad, number) {
  const value = gamepad.axes[number] || 0;
  const size = Math.max(0, Math.abs(value) - DEAD) / (1 - DEAD);
  return Math.sign(value) * Math.min(1, size);
}

function look() {
  const gamepad = found();
  if (gamepad === null) {
    if (had) {
      send({unplugged: true});
      say(pad, "The gamepad is unplugged, and the robot stands still. Plug it in and press a " +
          "button of it, or steer by keys.", true);
      had = ""; pressed = new Set();
    }
    return;
  }
  if (!had) {
    had = gamepad.id || "gamepad";
    send({unplugged: false});
    say(pad, "Gamepad: " + had.slice(0, 60), false);
  }
  const down = (number) => Boolean(gamepad.buttons[number] && gamepad.buttons[number].pressed);
  const move = [-axis(gamepad, 1), -axis(gamepad, 0), -axis(gamepad, 3)];
  const turn = [down(15) - down(14), down(13) - down(12), axis(gamepad, 2)];
  if ([...move, ...turn].some((value) => value !== 0)) send({move, turn});
  for (const [number, act] of Object.entries(BUTTONS)) {
    if (down(number) && !pressed.has(number)) send({press: act});
    if (down(number)) pressed.add(number); else pressed.delete(number);
  }
}

connect();
setInterval(look, PERIOD_MS);
</script>
</body>
</html>
"""
"""The page; everything that the server says is shown as text."""
