"""What stands at the end of viser's page: copying, and words for browsers without WebGL.

Viser's page shows nothing of ours before it draws, and has no button that copies. So a style and a
script are put behind it; everything that they show is a text of this file.
"""

from __future__ import annotations

NO_WEBGL_PATH = "/no-webgl"
"""What a browser asks for that cannot draw the scene."""

NO_WEBGL = (
    "a browser cannot draw the scene, because it has no WebGL: turn on hardware acceleration in "
    "its settings, or open the page in another browser; taskbuilder watch needs none"
)
"""What the terminal says then."""

TITLE = "taskbuilder view"

PAGE_END = f"""\
<style>
  .language-yaml, .language-diff {{ position: relative; white-space: pre-wrap !important;
                                   overflow-wrap: anywhere; }}
  .language-yaml {{ cursor: copy; padding-right: 7em !important; }}
  .language-yaml::after {{ content: "Click to copy"; position: absolute; top: 4px; right: 6px;
                          font: 11px sans-serif; color: #1d4ed8; }}
  .language-yaml.copied::after {{ content: "Copied"; color: #15803d; }}
  #no-webgl {{ position: fixed; inset: 0; z-index: 10000; overflow: auto; background: #fff;
              color: #1f2937; font: 15px/1.5 sans-serif; }}
  #no-webgl > div {{ max-width: 34em; margin: 4em auto; padding: 0 1.5em; }}
  #no-webgl h1 {{ font-size: 20px; }}
</style>
<template id="no-webgl-words"><div id="no-webgl" role="alert"><div>
  <h1>This browser cannot draw the scene</h1>
  <p>The page needs WebGL, which this browser does not have, or which is turned off in it. Turn on
  hardware acceleration in its settings and load the page again, or open the same address in
  another browser.</p>
  <p>Nothing is lost: the task, what is recorded and the other windows stay as they are.</p>
  <p>Without a browser, <code>taskbuilder watch TASK</code> checks a task whenever it is saved, and
  <code>taskbuilder demo TASK --video</code> films an episode.</p>
</div></div></template>
<script>
"use strict";
(() => {{
  const draws = () => {{
    try {{ return document.createElement("canvas").getContext("webgl2") !== null; }}
    catch {{ return false; }}
  }};
  if (!draws()) {{
    document.body.append(document.getElementById("no-webgl-words").content.cloneNode(true));
    fetch("{NO_WEBGL_PATH}").catch(() => {{}});
  }}

  const copied = async (text) => {{
    if (navigator.clipboard) return navigator.clipboard.writeText(text);
    const field = document.createElement("textarea");  // over http, there is no clipboard
    field.value = text;
    document.body.append(field);
    field.select();
    document.execCommand("copy");
    field.remove();
  }};
  document.addEventListener("click", async (event) => {{
    const block = event.target instanceof Element && event.target.closest(".language-yaml");
    if (!block || String(getSelection())) return;
    await copied(block.textContent.trimEnd() + "\\n");
    block.classList.add("copied");
    setTimeout(() => block.classList.remove("copied"), 2000);
  }});
}})();
</script>
"""
