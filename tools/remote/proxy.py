"""A proxy that counts and fails, also behind TLS. In: requests for another server. Out: its answers, some of them late, cut, changed or replaced by errors.

GET /__counts gives requests, bytes and faults since the last GET /__faults?rate=0.2&seed=1, which says how many requests fail, and how.
"""
import http.client
import json
import random
import threading
import time
import urllib.parse
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

KINDS = ["500", "503", "403", "cut", "slow", "gone", "flip", "replace"]
# How often each happens among the faults; a 403 or a replaced object ends a command, and would hide the rest.
WEIGHTS = [5, 3, 1, 5, 1, 3, 3, 1]


class Proxy(ThreadingHTTPServer):
    daemon_threads = True

    def __init__(self, target, replace=None, tls=None):
        super().__init__(("127.0.0.1", 0), Handler)
        if tls:
            self.socket = tls.wrap_socket(self.socket, server_side=True)
        self.target = target
        self.replace = replace
        self.lock = threading.Lock()
        self.reset(0, 0)
        threading.Thread(target=self.serve_forever, daemon=True).start()

    def reset(self, rate, seed, kinds=KINDS):
        with self.lock:
            self.rate, self.kinds, self.random = rate, kinds, random.Random(seed)
            self.counts = {"requests": 0, "bytes": 0, "faults": {}}

    def handle_error(self, request, client_address):
        # Clients that give up are part of the game.
        pass


class Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, *_):
        pass

    def any(self):
        server = self.server
        length = int(self.headers.get("Content-Length") or 0)
        body = self.rfile.read(length) if length else None
        with server.lock:
            fault = None
            if server.random.random() < server.rate:
                weights = [WEIGHTS[KINDS.index(kind)] for kind in server.kinds]
                fault = server.random.choices(server.kinds, weights)[0]
                server.counts["faults"][fault] = server.counts["faults"].get(fault, 0) + 1
            server.counts["requests"] += 1
        if fault == "gone":
            self.close_connection = True
            return
        if fault in ("500", "503", "403"):
            text = b"<Error><Code>Injected</Code></Error>"
            self.send_response(int(fault))
            self.send_header("Content-Length", str(len(text)))
            self.end_headers()
            self.wfile.write(text)
            return
        if fault == "replace" and server.replace:
            server.replace()
        link = http.client.HTTPConnection(server.target, timeout=60)
        headers = {name: value for name, value in self.headers.items() if name.lower() not in ("host", "connection")}
        headers["Host"] = server.target
        link.request(self.command, self.path, body, headers)
        answer = link.getresponse()
        data = answer.read()
        link.close()
        self.send_response(answer.status)
        for name, value in answer.getheaders():
            if name.lower() not in ("transfer-encoding", "connection", "server", "date", "content-length"):
                self.send_header(name, value)
        stated = answer.getheader("Content-Length") if self.command == "HEAD" else str(len(data))
        if stated is not None:
            self.send_header("Content-Length", stated)
        self.end_headers()
        if self.command == "HEAD":
            return
        if fault == "flip" and data:
            data = bytearray(data)
            data[len(data) // 2] ^= 1
        if fault in ("cut", "slow"):
            self.wfile.write(data[: len(data) // 2])
            self.wfile.flush()
            if fault == "slow":
                time.sleep(5)
            self.close_connection = True
            return
        self.wfile.write(data)
        with server.lock:
            server.counts["bytes"] += len(data)

    do_GET = do_HEAD = do_PUT = do_POST = do_DELETE = any
