"""What runs on a cluster of this machine. In: a cluster. Out: processes that workers started, workers that were killed, CPU seconds."""

import os
import random
import signal
import threading
import time

import psutil

#: How often processes are looked at, s: a build takes longer.
LOOK_EVERY = 0.05


class Children(threading.Thread):
    """Counts the processes of heliotile that workers start while it runs: builds need none."""

    def __init__(self, cluster):
        super().__init__(daemon=True)
        self.cluster, self.ended, self.found = cluster, threading.Event(), set()

    def run(self):
        while not self.ended.wait(LOOK_EVERY):
            for nanny in list(self.cluster.workers.values()):
                try:
                    children = psutil.Process(nanny.pid).children(recursive=True) if nanny.pid else []
                    self.found |= {child.pid for child in children if "heliotile" in " ".join(child.cmdline())}
                except psutil.NoSuchProcess:
                    pass

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self.ended.set()
        self.join()


class Killer(threading.Thread):
    """Kills a worker now and then, as a machine that is lost would; looks at the atlas each time."""

    def __init__(self, cluster, seed, kills, every_s, look):
        super().__init__(daemon=True)
        self.cluster, self.chance, self.kills, self.every_s, self.look = cluster, random.Random(seed), kills, every_s, look
        self.ended, self.done, self.looks = threading.Event(), 0, 0

    def run(self):
        while self.done < self.kills and not self.ended.wait(self.chance.uniform(0.2, 1.8) * self.every_s):
            workers = [nanny.pid for nanny in self.cluster.workers.values() if nanny.pid is not None]
            if not workers:
                continue
            os.kill(self.chance.choice(workers), signal.SIGKILL)
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
