"""The longest chain of dependent loads of a step of a walk, from the code that RADV makes for a GPU.

    python3 benches/dependent_loads.py FILE.s...

The files are those of `gpu_compile --isa`. A subgroup issues its instructions in order. So a load depends on another one if the subgroup
waits for that one before. A step is one round of the loop with the most loads. Of all ways through it, this finds the most loads that
follow one another: on the ways that read only nodes and pairs of faces, and on all.
"""

import re
import sys

# A way has at most so many loads that nobody has waited for yet. Older ones count as waited for.
MOST_OPEN = 16
TREES = {"nodes", "face_pairs"}


def blocks_of(lines):
    """The blocks of the code by their numbers, in order."""
    blocks, current = {}, None
    for line in lines:
        label = re.match(r"BB(\d+):", line)
        if label:
            current = blocks.setdefault(int(label[1]), [])
        elif current is not None:
            current.append(line.split(";")[0].strip())
    return blocks


def next_blocks(order, blocks, number):
    """The blocks that may follow this one."""
    found, falls = [], True
    for line in blocks[number]:
        branch = re.match(r"s_(c?)branch\S* BB(\d+)", line)
        if branch:
            found.append(int(branch[2]))
            falls = branch[1] == "c"
        if line.startswith("s_endpgm"):
            falls = False
    after = order.index(number) + 1
    return found + ([order[after]] if falls and after < len(order) else [])


def loop_of_walk(order, blocks):
    """The blocks of the innermost loop that has most of the loads of all loops."""
    loads = {number: sum("buffer_load" in line for line in blocks[number]) for number in order}
    ends = {}
    for number in order:
        for head in next_blocks(order, blocks, number):
            if order.index(head) <= order.index(number):
                ends[head] = max(ends.get(head, 0), order.index(number))
    loops = [order[order.index(head) : end + 1] for head, end in ends.items()]
    most = max(sum(loads[number] for number in loop) for loop in loops)
    return min((loop for loop in loops if sum(loads[number] for number in loop) > most / 2), key=len)


def run_block(lines, bindings, state):
    """What a way has done after a block: the tables that it has read, the loads in a row, and the rows of those not waited for."""
    read, waited, still_open, registers = state
    registers = dict(registers)
    for line in lines:
        descriptor = re.match(r"s_load_(?:b128|dwordx4) s\[(\d+):\d+\], s\[\d+:\d+\], (null|0x\w+|\d+)", line)
        load = re.match(r"buffer_load\S* v\S+ v\S+ s\[(\d+):", line)
        wait = re.match(r"s_waitcnt .*vmcnt\((\d+)\)", line)
        if descriptor:
            offset = 0 if descriptor[2] == "null" else int(descriptor[2], 0)
            registers[int(descriptor[1])] = bindings[offset // 16]
        elif load:
            read = read | {registers.get(int(load[1]), "?")}
            still_open = (still_open + (waited + 1,))[-MOST_OPEN:]
        elif wait:
            done = still_open[: max(0, len(still_open) - int(wait[1]))]
            still_open = still_open[len(done) :]
            waited = max((waited,) + done)
    return read, waited, still_open, frozenset(registers.items())


def longest_chains(path):
    """The most loads in a row on ways through trees alone, and on all."""
    with open(path) as file:
        bindings = file.readline()[1:].split()
        blocks = blocks_of(file)
    order = list(blocks)
    loop = loop_of_walk(order, blocks)
    # Descriptors that are read before the loop.
    before = (frozenset(), 0, (), frozenset())
    for number in order[: order.index(loop[0])]:
        before = run_block(blocks[number], bindings, before)
    ways = {number: set() for number in loop}
    ways[loop[0]] = {(frozenset(), 0, (), before[3])}
    ended = set()
    for number in loop:
        for state in ways[number]:
            after = run_block(blocks[number], bindings, state)
            for follows in next_blocks(order, blocks, number):
                if follows == loop[0]:
                    ended.add(after)
                elif follows in ways and order.index(follows) > order.index(number):
                    ways[follows].add(after)
    chain = lambda state: max((state[1],) + state[2])
    in_trees = [chain(state) for state in ended if state[0] and state[0] <= TREES]
    return max(in_trees, default=0), max(map(chain, ended))


for path in sys.argv[1:]:
    in_trees, on_all = longest_chains(path)
    print(f"{path}\t{in_trees}\t{on_all}")
    if path.endswith("planted.s") and on_all != 3:
        sys.exit("error: the planted kernel has three loads in a row")
