"""`taskbuilder mcp`: an agent's program writes, mends and plays a task through the protocol."""

from __future__ import annotations

import asyncio
import json
import sys

import pytest

pytest.importorskip("mcp")

from mcp.client import Client
from mcp.client.stdio import StdioServerParameters, stdio_client

from taskbuilder.agent_tools import TaskTools, make_server
from taskbuilder.errors import UsageError


def talk(folder, *calls):
    """The results of calls to a server that was started as an agent's program starts it."""

    async def all_of_them():
        words = ["-m", "taskbuilder", "mcp", "--dir", str(folder)]
        transport = stdio_client(StdioServerParameters(command=sys.executable, args=words))
        async with Client(transport) as client:
            return [await client.call_tool(name, arguments) for name, arguments in calls]

    return asyncio.run(all_of_them())


def test_a_task_is_written_mended_and_seen(tmp_path):
    talk(tmp_path, ("new_task", {"name": "carry", "robots": 1}))
    file = tmp_path / "carry.yaml"
    file.write_text(file.read_text().replace("grasp: cube.middle", "grasp: cube.midle"))
    checked, fixed, again, shown = talk(
        tmp_path,
        ("check_task", {"task": "carry"}),
        ("fix_task", {"task": "carry.yaml"}),
        ("check_task", {"task": "carry"}),
        ("render_task", {"task": "carry", "show": "grasps"}),
    )
    (finding,) = json.loads(checked.content[0].text)["tasks"][0]["findings"]
    assert finding["fix"]["new"] == "cube.middle"
    assert "{grasp: cube.middle}" in fixed.content[0].text
    assert json.loads(again.content[0].text)["ok"]
    text, picture = shown.content
    assert json.loads(text.text)["task"] == "carry"
    assert picture.mime_type == "image/png"


def test_every_tool_says_what_it_does(tmp_path):
    listed = asyncio.run(make_server(tmp_path).list_tools())
    assert {tool.name for tool in listed} == {
        *("list_tasks", "show_task", "new_task", "check_task", "fix_task"),
        *("render_task", "demo_task", "validate_task", "explain"),
    }
    assert all(tool.description for tool in listed)


@pytest.mark.parametrize("task", ["../outside.yaml", "/etc/hosts", "sub/../../outside.yaml"])
def test_nothing_outside_the_folder_is_read(task, tmp_path):
    (tmp_path / "outside.yaml").write_text("task: outside\n")
    (tmp_path / "inside" / "sub").mkdir(parents=True)
    with pytest.raises(UsageError, match="lies outside the folder"):
        TaskTools(tmp_path / "inside").check_task(task)


def test_a_link_that_leads_outside_is_not_followed(tmp_path):
    (tmp_path / "outside.yaml").write_text("task: outside\n")
    (tmp_path / "inside").mkdir()
    (tmp_path / "inside" / "link.yaml").symlink_to(tmp_path / "outside.yaml")
    with pytest.raises(UsageError, match="lies outside the folder"):
        TaskTools(tmp_path / "inside").fix_task("link.yaml")


def test_what_is_refused_is_said_in_a_sentence(tmp_path):
    tools = TaskTools(tmp_path)
    with pytest.raises(UsageError, match='no task "nowhere"'):
        tools.check_task("nowhere")
    with pytest.raises(UsageError, match="is no name of a task"):
        tools.new_task("../x")
    (refused,) = talk(tmp_path, ("new_task", {"name": "Bad Name"}))
    assert refused.is_error
    assert "is no name of a task" in refused.content[0].text


def test_a_folder_that_is_not_there_is_named(run, tmp_path):
    ran = run("mcp", "--dir", str(tmp_path / "none"))
    assert (ran.status, ran.out) == (2, "")
    assert "there is no folder none; make it first" in ran.err
