"""A large CityGML file, made by repeating the buildings of a small one. In: a file in a plane system, megabytes. Out: a file whose buildings stand on
a grid, each with ids of its own: what the figures of reading were measured with.

    repeat.py FILE.gml MEGABYTES OUT.gml
"""

import re
import sys

STEP_M = 250.0
COLUMNS = 200


def main(source, megabytes, out):
    text = open(source).read()
    members = re.findall(r"<core:cityObjectMember>.*?</core:cityObjectMember>\s*", text, re.S)
    buildings = "".join(member for member in members if "<bldg:Building" in member)
    head, foot = text[: text.index(members[0])], "</core:CityModel>\n"
    written, number = 0, 0
    with open(out, "w") as file:
        file.write(head)
        while written < megabytes * 1_000_000:
            east, north = STEP_M * (number % COLUMNS), STEP_M * (number // COLUMNS)

            def moved(found):
                numbers = [float(word) for word in found.group(2).split()]
                shifted = [value + (east, north, 0.0)[i % 3] for i, value in enumerate(numbers)]
                return found.group(1) + " ".join(f"{value:.3f}" for value in shifted) + "<"

            copy = re.sub(r"(<gml:pos(?:List)?>)([^<]+)<", moved, buildings)
            copy = copy.replace('gml:id="', f'gml:id="c{number}_').replace('href="#', f'href="#c{number}_')
            file.write(copy)
            written, number = written + len(copy), number + 1
        file.write(foot)
    print(f"{number} copies, {written / 1e6:.0f} MB")


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), sys.argv[3])
