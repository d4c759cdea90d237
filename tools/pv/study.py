"""Modules placed by heliotile beside independent ways. In: names of parts. Out: their tables."""

import sys

import cells
import field
import ground
import horizon
import rears
import rows
import sheds
import trackers
import walls

PARTS = {"field": field.main, "walls": walls.main, "rows": rows.main, "rears": rears.main, "sheds": sheds.main, "trackers": trackers.main, "cells": cells.main, "ground": ground.main, "horizon": horizon.main}

for part in sys.argv[1:] or PARTS:
    print(f"## {part}", flush=True)
    PARTS[part]()
