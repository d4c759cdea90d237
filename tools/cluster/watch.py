"""What runs on a cluster of this machine. In: a cluster, an atlas. Out: which builds there were and with how many threads, workers that were killed,
CPU seconds."""

import os
import random
import signal
import threading
import time

import psutil

#: How often processes are looked at, s: a build takes longer.
LOOK_EVERY = 0.05


class Builds(threading.Thread):
    """Counts the processes that build parts of an atlas while it runs, those of workers that were killed, too."""

    def __init__(self, atlas):
        super().__init__(daemon=True)
        self.atlas, self.ended = str(atlas), threading.Event()
        self.begun = {}
        self.most_at_once = self.most_threads = 0
        self.most_cores = 0.0

    def running(self):
        """Processes that build now, by number."""
        found = {}
        for process in psutil.process_iter(["cmdline", "status"]):
            words = process.info["cmdline"] or []
            if self.atlas in words and "--part" in words and process.info["status"] != psutil.STATUS_ZOMBIE:
                found[process.pid] = process
        return found

    def run(self):
        while not self.ended.wait(LOOK_EVERY):
            found = self.running()
            for number, process in found.items():
                try:
                    words = process.info["cmdline"]
                    self.begun.setdefault(number, words[words.index("--part") + 1])
                    self.most_threads = max(self.most_threads, process.num_threads())
                    age_s = time.time() - process.create_time()
                    # Times come in hundredths of a second.
                    if age_s > 0.5:
                        self.most_cores = max(self.most_cores, sum(process.cpu_times()[:2]) / age_s)
                except psutil.NoSuchProcess:
                    pass
            self.most_at_once = max(self.most_at_once, len(found))

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self.ended.set()
        self.join()


class Killer(threading.Thread):
    """Kills a worker now and then, every second time together with what it builds, as a machine that is lost would; looks at the atlas each time."""

    def __init__(self, cluster, seed, kills, every_s, look):
        super().__init__(daemon=True)
        self.cluster, self.chance, self.kills, self.every_s, self.look = cluster, random.Random(seed), kills, every_s, look
        self.ended, self.done, self.with_build, self.looks = threading.Event(), 0, 0, 0

    def run(self):
        while self.done < self.kills and not self.ended.wait(self.chance.uniform(0.2, 1.8) * self.every_s):
            workers = [nanny.pid for nanny in self.cluster.workers.values() if nanny.pid is not None]
            # A worker that has only just begun has nothing to lose.
            builds = {number: psutil.Process(number).children(recursive=True) for number in workers if psutil.pid_exists(number)}
            busy = [number for number in workers if builds.get(number)]
            if not busy:
                continue
            number = self.chance.choice(busy)
            os.kill(number, signal.SIGKILL)
            if self.done % 2:
                for build in builds[number]:
                    try:
                        os.kill(build.pid, signal.SIGKILL)
                    except ProcessLookupError:
                        pass
                self.with_build += 1
            self.done += 1
            time.sleep(0.05)
            self.looks += self.look()

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self.ended.set()
        self.join()


def cpu_seconds(cluster):
    """CPU seconds of the workers, of what they have waited for, and of this process, which schedules."""
    total = sum(os.times()[:2])
    for nanny in cluster.workers.values():
        used = psutil.Process(nanny.pid).cpu_times()
        total += used.user + used.system + used.children_user + used.children_system
    return total
