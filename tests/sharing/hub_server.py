"""A server of the Hugging Face Hub's protocol, as much of it as sharing needs, in memory.

Written from what the library sends and expects: repositories with commits and tags, private ones
for their owner alone, `.gitignore`, and large files by LFS. It has no transfers by Xet.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from fnmatch import fnmatch
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import unquote, urlsplit

WRITER, READER = "hf_writer", "hf_reader"
"""Tokens: of the owner of all repositories, and of somebody else."""

Files = dict[str, bytes]


class RefusalError(Exception):
    """A request is refused."""

    def __init__(self, status: int, code: str = "", message: str = "") -> None:
        super().__init__(message)
        self.status, self.code, self.message = status, code, message


@dataclass
class Repository:
    """A repository: its commits in order, its tags, and whether it is private."""

    private: bool
    commits: dict[str, Files] = field(default_factory=dict)
    tags: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.add({".gitattributes": b"*.npz filter=lfs diff=lfs merge=lfs -text\n"})

    @property
    def head(self) -> str:
        return list(self.commits)[-1]

    def add(self, files: Files) -> str:
        said = repr((len(self.commits), sorted(files.items()))).encode()
        name = hashlib.sha1(said).hexdigest()
        self.commits[name] = files
        return name

    def resolve(self, revision: str) -> str:
        names = {"main": self.head, **self.tags, **{name: name for name in self.commits}}
        if revision not in names:
            raise RefusalError(404, "RevisionNotFound")
        return names[revision]


class Hub:
    """All repositories, by their part of the hub and name: ``models/lab/robots``."""

    def __init__(self) -> None:
        self.repositories: dict[str, Repository] = {}
        self.large: dict[str, bytes] = {}
        self.url = ""
        self.full = False

    def found(self, name: str, token: str, *, write: bool = False) -> Repository:
        repository = self.repositories.get(name)
        if repository is None or (repository.private and token != WRITER):
            raise RefusalError(401 if not token else 404, "RepoNotFound")
        if write and token != WRITER:
            raise RefusalError(403, message="you have no rights here")
        return repository

    def create(self, token: str, asked: Any) -> dict[str, Any]:
        if token != WRITER:
            raise RefusalError(403 if token else 401, message="Invalid credentials")
        name = f"{asked.get('type') or 'model'}s/{asked['organization']}/{asked['name']}"
        if name in self.repositories:
            raise RefusalError(409, message="You already created this repo")
        private = asked.get("visibility", "") == "private" or asked.get("private", False)
        self.repositories[name] = Repository(private)
        return {"url": f"{self.url}/{name.removeprefix('models/')}"}

    def info(self, repository: Repository, name: str, revision: str) -> dict[str, Any]:
        sha = repository.resolve(revision)
        return {"id": name.partition("/")[2], "sha": sha, "private": repository.private}

    def tree(self, files: Files, folder: str, *, deep: bool) -> list[dict[str, Any]]:
        inside = {path for path in files if path.startswith(folder and f"{folder}/")}
        if folder and not inside:
            raise RefusalError(404, "EntryNotFound")
        depth = folder.count("/") + 1 if folder else 0
        entries = []
        for path in sorted({p if deep else "/".join(p.split("/")[: depth + 1]) for p in inside}):
            oid = hashlib.sha1(path.encode()).hexdigest()
            if path in files:
                size = len(files[path])
                entries.append({"type": "file", "path": path, "size": size, "oid": oid})
            else:
                entries.append({"type": "directory", "path": path, "size": 0, "oid": oid})
        return entries

    def preupload(self, files: Files, asked: Any) -> dict[str, Any]:
        ignored = asked.get("gitIgnore", files.get(".gitignore", b"").decode()).split()
        return {
            "files": [
                {
                    "path": each["path"],
                    "uploadMode": "lfs" if each["path"].endswith(".npz") else "regular",
                    "shouldIgnore": any(fnmatch(each["path"], rule) for rule in ignored),
                }
                for each in asked["files"]
            ]
        }

    def batch(self, asked: Any) -> dict[str, Any]:
        objects = []
        for each in asked["objects"]:
            href = {"href": f"{self.url}/large/{each['oid']}"}
            missing = {} if each["oid"] in self.large else {"actions": {"upload": href}}
            objects.append({**each, **missing})
        return {"transfer": "basic", "objects": objects}

    def commit(self, repository: Repository, lines: list[Any]) -> dict[str, Any]:
        header, *operations = lines
        if header["value"].get("parentCommit", repository.head) != repository.head:
            raise RefusalError(412, message="the branch has moved on")
        files = dict(repository.commits[repository.head])
        for operation in operations:
            value = operation["value"]
            if operation["key"] == "file":
                files[value["path"]] = base64.b64decode(value["content"])
            elif operation["key"] == "lfsFile":
                files[value["path"]] = self.large[value["oid"]]
            elif operation["key"] == "deletedFile":
                del files[value["path"]]
            else:
                raise RefusalError(400, message=f"an operation {operation['key']}")
        oid = repository.add(files)
        return {"commitOid": oid, "commitUrl": f"{self.url}/lab/robots/commit/{oid}"}

    def tag(self, repository: Repository, revision: str, asked: Any) -> dict[str, Any]:
        if asked["tag"] in repository.tags:
            raise RefusalError(409, message="Tag reference exists already")
        repository.tags[asked["tag"]] = repository.resolve(revision)
        return {}


class Handler(BaseHTTPRequestHandler):
    """Requests of the library."""

    hub: Hub
    protocol_version = "HTTP/1.1"

    def __getattr__(self, name: str) -> Any:
        if name in ("do_POST", "do_PUT", "do_HEAD"):
            return self.do_GET
        raise AttributeError(name)

    def log_message(self, *_: object) -> None:
        """Say nothing."""

    def do_GET(self) -> None:
        """Answer a request of any method."""
        length = int(self.headers.get("Content-Length") or 0)
        body = self.rfile.read(length)
        try:
            content, headers = self.handled(body)
            status = 200
        except RefusalError as refusal:
            status, content = refusal.status, b"{}"
            headers = {"X-Error-Code": refusal.code, "X-Error-Message": refusal.message}
        self.send_response(status)
        for name, value in {**headers, "Content-Length": str(len(content))}.items():
            if value:
                self.send_header(name, value)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)

    def handled(self, body: bytes) -> tuple[bytes, dict[str, str]]:
        address = urlsplit(self.path)
        path = unquote(address.path)
        token = self.headers.get("Authorization", "").removeprefix("Bearer ")
        if self.command == "PUT" and path.startswith("/large/"):
            if self.hub.full:
                raise RefusalError(413, message="there is no space left")
            self.hub.large[path.removeprefix("/large/")] = body
            return b"", {}
        if file := re.fullmatch(r"/(datasets/)?([^/]+/[^/]+)/resolve/([^/]+)/(.+)", path):
            repository = self.hub.found(f"{file[1] or 'models/'}{file[2]}", token)
            commit = repository.resolve(file[3])
            if file[4] not in repository.commits[commit]:
                raise RefusalError(404, "EntryNotFound")
            content = repository.commits[commit][file[4]]
            etag = f'"{hashlib.sha1(content).hexdigest()}"'
            return content, {"ETag": etag, "X-Repo-Commit": commit}
        answer = self.answered(path, "recursive=true" in address.query.lower(), token, body)
        return json.dumps(answer).encode(), {"Content-Type": "application/json"}

    def answered(self, path: str, deep: bool, token: str, body: bytes) -> Any:
        if path == "/api/repos/create":
            return self.hub.create(token, json.loads(body))
        if batch := re.fullmatch(r"/(datasets/)?([^/]+/[^/]+)\.git/info/lfs/objects/batch", path):
            self.hub.found(f"{batch[1] or 'models/'}{batch[2]}", token, write=True)
            return self.hub.batch(json.loads(body))
        asked = re.fullmatch(
            r"/api/((?:models|datasets)/[^/]+/[^/]+)(?:/(\w+)/([^/]+)(?:/(.*))?)?", path
        )
        if asked is None:
            raise RefusalError(400, message=f"there is no {path}")
        name, what, revision, folder = asked.groups()
        repository = self.hub.found(name, token, write=self.command != "GET")
        if what in (None, "revision"):
            return self.hub.info(repository, name, revision or "main")
        if what == "commit":
            return self.hub.commit(repository, [json.loads(line) for line in body.splitlines()])
        if what == "tag":
            return self.hub.tag(repository, revision, json.loads(body))
        files = repository.commits[repository.resolve(revision)]
        if what == "preupload":
            return self.hub.preupload(files, json.loads(body))
        return self.hub.tree(files, folder or "", deep=deep)


@contextmanager
def serve() -> Iterator[Hub]:
    """A hub that answers until the block ends."""
    hub = Hub()
    handler = type("HandlerOfHub", (Handler,), {"hub": hub})
    server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
    hub.url = f"http://127.0.0.1:{server.server_address[1]}"
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield hub
    finally:
        server.shutdown()
        thread.join()
        server.server_close()
