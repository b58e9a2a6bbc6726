#!/usr/bin/env python3
"""stack_depth - worst-case stack of an image, from the compiler's own call graph.

usage: tests/stack_depth.py --entry FUNCTION [--interrupt FUNCTION+BYTES] [--verbose] IMAGE.map

Walks the .ci files (gcc -fcallgraph-info=su) beside the objects that the map file names. Fails, because there is no
bound, on recursion, on a frame of variable size, on an indirect call that tests/stack_calls.txt does not resolve and on
a function without a .ci that it does not give a bound for. --interrupt adds one interrupt on top: its function's depth
and the BYTES that the core stores on entry. Prints `N bytes` and, with --verbose, the deepest chain.
"""
import argparse
import fnmatch
import os
import re
import sys

NODE = re.compile(r'node: \{ title: "([^"]+)" label: "([^"]*)"')
EDGE = re.compile(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"')
SIZE = re.compile(r"\\n(\d+) bytes \(([^)]*)\)")
INDIRECT = "__indirect_call"
RULES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "stack_calls.txt")


class Unbounded(Exception):
    """Why there is no worst case."""


def objects_of(map_path):
    """Our objects linked into the image; libgcc is an archive and comes in as such."""
    with open(map_path, encoding="utf-8", errors="replace") as file:
        return re.findall(r"^LOAD (\S+\.o)$", file.read(), re.M)


def read_graph(paths):
    """{function: frame bytes}, {function: set of callees}. A weak function and the one that replaces it share a name:
    the larger frame and all calls count."""
    frames, calls = {}, {}
    for path in paths:
        with open(path, encoding="utf-8") as file:
            text = file.read()
        for name, label in NODE.findall(text):
            size = SIZE.search(label)
            if size is None:
                continue
            if "dynamic" in size[2] and "bounded" not in size[2]:
                raise Unbounded(f"{name}: frame of variable size")
            frames[name] = max(frames.get(name, 0), int(size[1]))
        for caller, callee in EDGE.findall(text):
            calls.setdefault(caller, set()).add(callee)
    return frames, calls


def read_rules(path):
    """Lines `call CALLER CALLEE...` (who is behind a pointer) and `bound PATTERN BYTES` (no .ci)."""
    indirect, bounds = {}, []
    with open(path, encoding="utf-8") as file:
        for line in file:
            words = line.split("#")[0].split()
            if words and words[0] == "call":
                indirect[words[1]] = words[2:]
            elif words and words[0] == "bound":
                bounds.append((words[1], int(words[2])))
    return indirect, bounds


class Walk:
    def __init__(self, frames, calls, indirect, bounds):
        self.frames, self.calls, self.indirect, self.bounds = frames, calls, indirect, bounds
        self.known, self.path = {}, []

    def depth(self, name):
        """(bytes, chain) of the deepest way down from name."""
        if name in self.path:
            raise Unbounded("recursion: " + " -> ".join(self.path[self.path.index(name):] + [name]))
        if name not in self.known:
            self.path.append(name)
            own = self.frame(name)
            below = max((self.depth(callee) for callee in self.callees(name)), default=(0, []))
            self.known[name] = (own + below[0], [f"{name} {own}"] + below[1])
            self.path.pop()
        return self.known[name]

    def frame(self, name):
        if name in self.frames:
            return self.frames[name]
        for pattern, size in self.bounds:
            if fnmatch.fnmatchcase(name, pattern):
                return size
        raise Unbounded(f"{name}: no call graph and no bound (called from {' -> '.join(self.path[:-1])})")

    def callees(self, name):
        for callee in sorted(self.calls.get(name, ())):
            if callee != INDIRECT:
                yield callee
            elif name.split(":")[-1] not in self.indirect:
                raise Unbounded(f"{name}: indirect call, not in {os.path.basename(RULES)}")
            else:
                yield from (self.resolve(c) for c in self.indirect[name.split(":")[-1]] if self.resolve(c))

    def resolve(self, short):
        """The title of a function: `name`, or `file.c:name` where it is static; None where this image lacks it."""
        return next((t for t in self.frames if t.split(":")[-1] == short), None)


def stack_depth(map_path, entry, interrupt=None, rules=RULES):
    """(bytes, chain); raises Unbounded."""
    paths = [o[:-2] + ".ci" for o in objects_of(map_path)]
    graph = read_graph([p for p in paths if os.path.exists(p)])
    walk = Walk(*graph, *read_rules(rules))
    total, chain = walk.depth(entry)
    if interrupt:
        name, stored = interrupt.split("+")
        more, on_top = walk.depth(name)
        total, chain = total + more + int(stored), chain + [f"interrupt {stored}"] + on_top
    return total, chain


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1])
    parser.add_argument("--entry", required=True)
    parser.add_argument("--interrupt")
    parser.add_argument("--verbose", action="store_true")
    parser.add_argument("map")
    args = parser.parse_args()
    try:
        total, chain = stack_depth(args.map, args.entry, args.interrupt)
    except Unbounded as why:
        print(f"stack_depth: {args.map}: {why}", file=sys.stderr)
        return 1
    print(f"{total} bytes")
    if args.verbose:
        print("\n".join("  " + link for link in chain))
    return 0


if __name__ == "__main__":
    sys.exit(main())
