"""Archives in an object store: are they read as from a file, in how many requests, and whatever the store does?

In: an archive, a program built with `--features remote`. Out: a table, and exit code 1 where something is not as it should be.
"""
import argparse
import functools
import http.client
import json
import os
import shutil
import socket
import ssl
import subprocess
import sys
import tempfile
import threading
import time
from http.server import BaseHTTPRequestHandler, SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import trustme
from proxy import KINDS, Proxy

BUCKET = "bucket"
# As long as the bucket's address: some files say how long the command was that made them.
LOCAL = "near_folder"
FAILED = []


def check(good, what):
    if not good:
        FAILED.append(what)
        print(f"WRONG: {what}", flush=True)


def free_port():
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


def ask(host, method, path, body=None, headers={}):
    link = http.client.HTTPConnection(host, timeout=120)
    link.request(method, path, body, headers)
    answer = link.getresponse()
    data = answer.read()
    link.close()
    return answer.status, data


def wait_for(host):
    for _ in range(200):
        try:
            return ask(host, "GET", "/")
        except OSError:
            time.sleep(0.1)
    sys.exit(f"{host} does not answer")


class Quiet(SimpleHTTPRequestHandler):
    """Files of a folder, without a log."""

    def log_message(self, *_):
        pass

    def handle(self):
        try:
            super().handle()
        except OSError:
            # Clients that do not trust it hang up.
            pass


class Study:
    def __init__(self, args, folder):
        self.args, self.folder = args, folder
        self.program = os.path.abspath(args.program)
        port = free_port()
        self.s3 = f"127.0.0.1:{port}"
        log = open(folder / "moto.log", "w")
        self.moto = subprocess.Popen([args.moto, "-H", "127.0.0.1", "-p", str(port)], stdout=log, stderr=log)
        wait_for(self.s3)
        ask(self.s3, "PUT", f"/{BUCKET}")
        self.proxy = Proxy(self.s3, self.replace)
        self.proxied = f"127.0.0.1:{self.proxy.server_address[1]}"
        self.file = folder / "site.helio"
        shutil.copy(args.archive, self.file)
        (folder / LOCAL).mkdir()
        (folder / LOCAL / "site.helio").hardlink_to(self.file)
        self.original = self.file.read_bytes()
        self.swapped = False
        self.environment = {k: v for k, v in os.environ.items() if not k.startswith(("AWS_", "HELIOTILE_"))}

    def end(self):
        self.moto.terminate()
        self.moto.wait()

    def replace(self):
        """Puts another object in the place of the one that is read."""
        other = bytearray(self.original)
        other[8192:] = bytes(b ^ 0x55 for b in other[8192 : 8192 + 4096]) + other[8192 + 4096 :]
        self.put("site.helio", bytes(other))
        self.swapped = True

    def put(self, name, data):
        # moto asks who writes what is there, and not whether that is true.
        signed = "AWS4-HMAC-SHA256 Credential=me/20261101/us-east-1/s3/aws4_request, SignedHeaders=host, Signature=0"
        status, _ = ask(self.s3, "PUT", f"/{BUCKET}/{name}", data, {"Authorization": signed})
        assert status == 200, status

    def run(self, line, cache="off", timeout=60, wait="2", **more):
        words = [word.replace("CONDITIONS", str(self.conditions)).replace("WEATHER", self.weather) for word in line.split()]
        environment = dict(
            self.environment, AWS_ENDPOINT_URL=f"http://{self.proxied}", AWS_ACCESS_KEY_ID="me",
            AWS_SECRET_ACCESS_KEY="s3cret", AWS_REGION="us-east-1", HELIOTILE_CACHE=str(cache), HELIOTILE_TIMEOUT=wait,
        )
        environment = {name: value for name, value in (environment | more).items() if value is not None}
        begun = time.monotonic()
        ran = subprocess.run([self.program, *words], cwd=self.folder, env=environment, capture_output=True, timeout=timeout)
        return ran.returncode, ran.stdout, ran.stderr.decode(), time.monotonic() - begun

    def counted(self, line, **more):
        self.proxy.reset(0, 0)
        ran = self.run(line, timeout=1200, wait="60", **more)
        return ran, dict(self.proxy.counts)

    def prepare(self):
        self.conditions = self.folder / "conditions.csv"
        self.conditions.write_text(
            "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nnoon,180,55,850,110\novercast,180,30,0,200\n"
        )
        self.weather = os.path.abspath(self.args.weather)
        first = self.run("export site.helio --view-factors -o -")[1].decode().splitlines()
        ids = [line.split(",")[0] for line in first[1:]]
        self.receiver = ids[len(ids) // 2]
        listed = self.folder / "one.csv"
        surface = self.receiver.rsplit("#", 1)[0]
        building = surface.split("/")[0]
        own = [name for name in ids if name.startswith(building)] or [self.receiver]
        listed.write_text("receiver\n" + "".join(f"{name}\n" for name in own))
        self.run("archive extract site.helio -r one.csv -o one.helio")
        print(f"{len(self.original) / 1e6:.1f} MB, {len(ids)} receivers; the building has {len(own)}", flush=True)

    def publish(self):
        (code, _, said, seconds), counts = self.counted(f"archive copy site.helio s3://{BUCKET}/site.helio")
        check(code == 0, f"copy: {said}")
        print(f"copy to the store: {counts['requests']} requests, {seconds:.1f} s", flush=True)
        (code, _, said, seconds), counts = self.counted(f"archive copy s3://{BUCKET}/site.helio back.helio")
        check(code == 0 and (self.folder / "back.helio").read_bytes() == self.original, f"copy back: {said}")
        print(f"copy back: {counts['requests']} requests, {counts['bytes'] / 1e6:.1f} MB, {seconds:.1f} s", flush=True)

    def commands(self):
        lines = [
            "info AT", "archive verify AT", "replay AT --conditions CONDITIONS -o OUT.csv",
            "replay AT -r one.csv --weather WEATHER --every month -o OUT.csv",
            "replay AT -r one.csv --weather WEATHER --every month --reflectance ground=0.4 -o OUT.csv",
            "archive extract AT -r one.csv -o OUT.helio",
            f"export AT -r {self.receiver} -o OUT.exr", "export AT --view-factors -o OUT.csv",
        ]
        if not self.args.short:
            lines += [
                "replay AT --weather WEATHER --every year --by surface -o OUT.csv", "energyplus factors AT -r one.csv -o OUT.csv",
                "buildings AT --weather WEATHER -o OUT.csv", "places AT --weather WEATHER --best 5 -o OUT.csv",
                "archive merge AT one.helio -o OUT.helio", "archive diff AT one.helio",
            ]
        lines = [line for line in lines if self.args.commands in line]
        print(f"{'command':<74} {'file s':>7} {'cold s':>7} {'requests':>8} {'MB':>7} {'warm s':>7} {'requests':>8} {'MB':>7}")
        for line in lines:
            results = []
            cache = self.folder / "cache"
            shutil.rmtree(cache, ignore_errors=True)
            for place in [f"{LOCAL}/site.helio", f"s3://{BUCKET}/site.helio", f"s3://{BUCKET}/site.helio"]:
                for old in self.folder.glob("OUT.*"):
                    old.unlink()
                ran, counts = self.counted(line.replace("AT", place, 1) if not line.startswith(("archive merge", "archive diff")) else line.replace(" AT", " " + place), cache=cache)
                plain = lambda data: data.replace(f"s3://{BUCKET}".encode(), LOCAL.encode())
                files = {path.name: plain(path.read_bytes()) for path in sorted(self.folder.glob("OUT.*"))}
                results.append((ran[0], plain(ran[1]), files, ran[3], counts))
                check(ran[0] in (0, 1), f"{line}: {ran[2]}")
            near, cold, warm = results
            named = line.replace("WEATHER", "w.epw").replace("CONDITIONS", "c.csv").replace("AT", "URL")
            check(near[:2] == cold[:2] == warm[:2] or line.startswith(("archive extract", "archive merge")), f"{line}: prints something else")
            check(near[2] == cold[2] == warm[2], f"{line}: writes something else")
            print(
                f"{named[:74]:<74} {near[3]:7.2f} {cold[3]:7.2f} {cold[4]['requests']:8} {cold[4]['bytes'] / 1e6:7.2f} "
                f"{warm[3]:7.2f} {warm[4]['requests']:8} {warm[4]['bytes'] / 1e6:7.2f}", flush=True,
            )

    def faults(self):
        """Queries until so many faults were met."""
        small = self.folder / "small.helio"
        source = self.args.small or self.args.archive
        shutil.copy(source, small)
        self.original = small.read_bytes()
        self.put("site.helio", self.original)
        line = "replay PLACE --conditions CONDITIONS"
        near = self.run(line.replace("PLACE", "small.helio"))[1]
        right = refused = met = rounds = 0
        wrong_before = len(FAILED)
        kinds, slowest = {}, 0
        while met < self.args.faults:
            if self.swapped:
                self.put("site.helio", self.original)
                self.swapped = False
            self.proxy.reset(0.25, rounds, KINDS if rounds % 5 == 0 else [k for k in KINDS if k not in ("403", "replace")])
            try:
                code, out, said, seconds = self.run(line.replace("PLACE", f"s3://{BUCKET}/site.helio"), timeout=60)
            except subprocess.TimeoutExpired:
                check(False, f"round {rounds} hangs")
                break
            rounds += 1
            slowest = max(slowest, seconds)
            faults = self.proxy.counts["faults"]
            met += sum(faults.values())
            for kind, count in faults.items():
                kinds[kind] = kinds.get(kind, 0) + count
            if code == 0:
                right += 1
                check(out == near, f"round {rounds}: a wrong table")
            else:
                refused += 1
                clear = code == 2 and "to fix: " in said and "s3://" in said and "s3cret" not in said and "panicked" not in said
                check(clear and near.startswith(out), f"round {rounds}: {code} {said}")
        print(f"{met} faults in {rounds} queries ({', '.join(f'{k} {n}' for k, n in sorted(kinds.items()))}): "
              f"{right} gave the table, {refused} an error, {len(FAILED) - wrong_before} of these wrong or unclear; the slowest took {slowest:.1f} s", flush=True)

    def writers(self):
        """Two programs that publish two archives under one name."""
        self.proxy.reset(0, 0)
        ends = []
        for number in range(self.args.races):
            name = f"s3://{BUCKET}/race{number}.helio"
            ended = [None, None]

            def write(which, path):
                ended[which] = self.run(f"archive copy {path} {name}", timeout=300, wait="60")

            threads = [threading.Thread(target=write, args=pair) for pair in enumerate(["site.helio", "one.helio"])]
            [thread.start() for thread in threads]
            [thread.join() for thread in threads]
            ends.append(tuple(end[0] for end in ended))
            check(sorted(ends[-1]) == [0, 2], f"race: {ended}")
            code, _, said, _ = self.run(f"archive verify {name}", timeout=300, wait="60")
            check(code == 0, f"race: {said}")
        print(f"{len(ends)} races of two writers: {ends.count((0, 2))} won by the first, {ends.count((2, 0))} by the second, {len([end for end in ends if sorted(end) != [0, 2]])} otherwise", flush=True)

    def tls(self):
        """S3 and a plain server behind TLS: with a certificate that is trusted, one that is not, one of another host."""
        line = "replay PLACE --conditions CONDITIONS"
        near = self.run(line.replace("PLACE", "small.helio"))[1]
        self.put("small.helio", (self.folder / "small.helio").read_bytes())
        authority = trustme.CA()
        trusted = self.folder / "authority.pem"
        authority.cert_pem.write_to_path(str(trusted))
        for host, trust, words in [
            ("127.0.0.1", str(trusted), None), ("127.0.0.1", None, "certificate"), ("elsewhere.example", str(trusted), "certificate"),
        ]:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            authority.issue_cert(host).configure_cert(context)
            address = f"https://127.0.0.1:{Proxy(self.s3, tls=context).server_address[1]}"
            served = ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=str(self.folder)))
            served.socket = context.wrap_socket(served.socket, server_side=True)
            threading.Thread(target=served.serve_forever, daemon=True).start()
            for place in [f"s3://{BUCKET}/small.helio", f"https://127.0.0.1:{served.server_address[1]}/small.helio"]:
                begun = time.monotonic()
                code, out, said, _ = self.run(line.replace("PLACE", place), SSL_CERT_FILE=trust, SSL_CERT_DIR=None, AWS_ENDPOINT_URL=address, wait="10")
                seconds = time.monotonic() - begun
                if words is None:
                    check(code == 0 and out == near, f"TLS, {place}: {said}")
                else:
                    check(code == 2 and words in said and "SSL_CERT_FILE" in said and seconds < 5, f"TLS, {place}, {seconds:.1f} s: {said}")
            served.shutdown()
            print(f"TLS, a certificate of {host}, {'trusted' if trust else 'not trusted'}: {said.strip() or 'as from a file'}", flush=True)

    def container(self):
        """Keys that a machine or a container gets from a service beside it, in place of the environment's."""
        asked = []

        class Keys(BaseHTTPRequestHandler):
            def do_GET(self):
                asked.append((self.path, self.headers.get("Authorization")))
                later = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(time.time() + 3600))
                text = json.dumps({"AccessKeyId": "me", "SecretAccessKey": "s3cret", "Token": "session", "Expiration": later}).encode()
                self.send_response(200)
                self.send_header("Content-Length", str(len(text)))
                self.end_headers()
                self.wfile.write(text)

            def log_message(self, *_):
                pass

        server = ThreadingHTTPServer(("127.0.0.1", 0), Keys)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        token = self.folder / "token"
        token.write_text("secret token")
        line = "replay PLACE --conditions CONDITIONS"
        near = self.run(line.replace("PLACE", "small.helio"))[1]
        code, out, said, _ = self.run(
            line.replace("PLACE", f"s3://{BUCKET}/small.helio"), AWS_ACCESS_KEY_ID=None, AWS_SECRET_ACCESS_KEY=None,
            AWS_CONTAINER_CREDENTIALS_FULL_URI=f"http://127.0.0.1:{server.server_address[1]}/keys", AWS_CONTAINER_AUTHORIZATION_TOKEN_FILE=str(token),
        )
        check(code == 0 and out == near and asked[:1] == [("/keys", "secret token")], f"container: {asked} {said}")
        print(f"keys of a container: {'as from a file' if code == 0 else said.strip()}", flush=True)
        server.shutdown()

    def web(self):
        """Web servers: one without ranges, and nginx."""
        line = "replay PLACE --conditions CONDITIONS"
        near = self.run(line.replace("PLACE", "small.helio"))[1]
        port = free_port()
        server = subprocess.Popen([sys.executable, "-m", "http.server", str(port), "--bind", "127.0.0.1"], cwd=self.folder,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wait_for(f"127.0.0.1:{port}")
        code, out, said, _ = self.run(line.replace("PLACE", f"http://127.0.0.1:{port}/small.helio"))
        check(code == 0 and out == near, f"http.server: {said}")
        code, out, said, _ = self.run(f"info http://127.0.0.1:{port}/site.helio")
        large = self.file.stat().st_size > 50_000_000
        check(code == (2 if large else 0), f"http.server: {said}")
        print(f"python -m http.server: the small archive is read whole; the large one: {said.strip() or 'whole'}")
        server.terminate()
        nginx = shutil.which("nginx")
        if not nginx:
            print("nginx is not installed: apt-get install nginx-light")
            return
        port = free_port()
        (self.folder / "nginx.conf").write_text(
            f"daemon off; pid {self.folder}/nginx.pid; error_log {self.folder}/nginx.log; events {{}} http {{ access_log off; "
            f"client_body_temp_path {self.folder}/t1; proxy_temp_path {self.folder}/t2; fastcgi_temp_path {self.folder}/t3; "
            f"uwsgi_temp_path {self.folder}/t4; scgi_temp_path {self.folder}/t5; "
            f"server {{ listen 127.0.0.1:{port}; root {self.folder}; location /moved/ {{ rewrite ^/moved/(.*)$ /$1 redirect; }} }} }}"
        )
        os.chmod(self.folder, 0o755)
        server = subprocess.Popen([nginx, "-c", str(self.folder / "nginx.conf")], stderr=subprocess.DEVNULL)
        wait_for(f"127.0.0.1:{port}")
        for path in ["small.helio", "moved/small.helio"]:
            code, out, said, seconds = self.run(line.replace("PLACE", f"http://127.0.0.1:{port}/{path}"))
            check(code == 0 and out == near, f"nginx: {said}")
            print(f"nginx, /{path}: as from a file, {seconds:.2f} s")
        server.terminate()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", default="target/release/heliotile")
    parser.add_argument("--moto", required=True)
    parser.add_argument("--archive", required=True)
    parser.add_argument("--small")
    parser.add_argument("--weather", default="tests/data/weather/golden_tmy3.epw")
    parser.add_argument("--faults", type=int, default=1000)
    parser.add_argument("--races", type=int, default=5)
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--commands", default="", help="run only the commands that contain these words")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        study = Study(args, Path(folder))
        try:
            study.prepare()
            study.publish()
            study.commands()
            study.faults()
            study.writers()
            study.tls()
            study.container()
            study.web()
        finally:
            study.end()
    sys.exit(1 if FAILED else 0)


main()
