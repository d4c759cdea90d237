"""The order in which crates are published. In: `cargo metadata --no-deps` on standard input. Out: names, each after those that it depends on."""
import json
import sys

packages = {p["name"]: p for p in json.load(sys.stdin)["packages"] if p["publish"] != []}
done = []


def add(name):
    if name in done:
        return
    for dependency in packages[name]["dependencies"]:
        # Tests are not published.
        if dependency["name"] in packages and dependency["kind"] != "dev":
            add(dependency["name"])
    done.append(name)


for name in sorted(packages):
    add(name)
print(*(f"cargo publish --package {name}" for name in done), sep="\n")
