"""Prints the tables of scaling.md that follow from its measurements: `python3 docs/scaling.py < docs/scaling.md`."""

import math
import re
import sys

SAMPLES, RUN = 100_000, 8
NODES = (1, 16, 64, 256, 1000)


def short(value):
    """A number with three digits."""
    return f"{value:.{min(max(2 - math.floor(math.log10(value)), 0), 6)}f}"


def duration(s):
    forms = ((7200, f"{s / 3600:.1f} h"), (600, f"{s / 60:.0f} min"), (100, f"{s:.0f} s"), (1, f"{s:.1f} s"), (0, f"{1e3 * s:.0f} ms"))
    return next(text for least, text in forms if s >= least)


class Scene:
    def __init__(self, name, cells):
        self.name = name
        _, self.start, self.pace, self.write, self.bytes, self.merge = map(float, cells)

    def part(self, samples, faster):
        """Seconds of a part, with its checkpoints."""
        render = samples * self.pace / faster
        return self.start + render + (render // 60 + 1) * self.write

    def joining(self, parts, in_groups):
        """Seconds of the merge: of all parts, or of groups at the same time, and then of their results."""
        if in_groups:
            return 2 * (math.ceil(math.sqrt(parts)) * self.merge + self.write) + 30
        return parts * self.merge + self.write

    def best(self, nodes, faster=1, in_groups=False):
        """The least time, and the parts and the samples a part that make it."""
        def split(samples):
            parts = math.ceil(SAMPLES / samples)
            tasks = 30 + parts / 100 + math.ceil(parts / nodes) * self.part(samples, faster) + 30
            return tasks + self.joining(parts, in_groups), parts, samples
        return min(map(split, range(SAMPLES, 0, -RUN)), key=lambda found: found[0])

    def row(self, nodes):
        time, parts, samples = self.best(nodes)
        faster = []
        for seconds, used, _ in (self.best(nodes, 10), self.best(nodes, 100)):
            faster.append(duration(seconds) + (f" ({used})" if used < nodes else ""))
        return (
            nodes, parts, samples, duration(time), short(self.best(1)[0] / time), f"{100 * self.joining(parts, False) / time:.0f} %",
            f"{parts * self.bytes / 1e9:.1f} GB", duration(self.best(nodes, 1, True)[0]), *faster,
        )

    def failures(self, rate, nodes):
        """The failures of all nodes, and by how much the most that one part meets delay the render, in time and in percent: their mean
        by Poisson's law."""
        time, parts, samples = self.best(nodes)
        mean = rate / 3600 * self.part(samples, 1) * math.ceil(parts / nodes)
        most, term, below = 0.0, math.exp(-mean), 0.0
        for count in range(100):
            below = min(below + term, 1)
            most += 1 - below**nodes
            term *= mean / (count + 1)
        delay = (30 + self.start + 420) * most
        return f"{short(mean * nodes)}, {duration(delay)}, {100 * delay / time:.2f} %"


def table(heads, rows):
    lines = [f"| {' | '.join(map(str, row))} |" for row in (heads, *rows)]
    print("", lines[0], "|" + "---:|" * len(heads), *lines[1:], sep="\n")


measured = re.search(r"## What was measured.*?\n\n\| \|(.*?)\n\n", sys.stdin.read(), re.S)[1]
names, _, *rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in measured.splitlines())
scenes = [Scene(name, cells) for name, *cells in zip(names, *(row[1:] for row in rows))]
for scene in scenes:
    print(f"\n### {scene.name}")
    heads = "nodes", "parts", "samples a part", "time", "speed-up", "of it merging", "disk", "merged in groups", "nodes 10 times as fast", "100 times"
    table(heads, map(scene.row, NODES))
print("\n## Failures")
cases = [(scene, nodes) for scene in scenes for nodes in (16, 256)]
heads = ["failures of a node in an hour", *(f"{scene.name}, {nodes} nodes" for scene, nodes in cases)]
table(heads, ([f"1e-{power}", *(scene.failures(10**-power, nodes) for scene, nodes in cases)] for power in (4, 2)))
