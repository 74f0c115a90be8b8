#!/usr/bin/env python3
"""Runs the firmware in QEMU, compares its forces with the desktop's and guards its instructions.

    firmware.py check  STORED DIRECTORY    ends with 1 if a force differs by a bit, an instruction count is 3 % above the
                                           stored one, an image has a heap, one in float computes in a double or takes
                                           more than 6000 instructions, or a driver is larger than it may be
    firmware.py update STORED DIRECTORY    writes the figures of this compiler into STORED

DIRECTORY has the images and the programs of the desktop. QEMU counts instructions, so the figures are the same on every
machine. Another compiler makes other images: STORED has figures for each. Where it has none, the figures are shown and not
compared, and that is said; nor are sizes.
"""
import json
import pathlib
import re
import subprocess
import sys

ALLOWED = 3.0  # percent
IMAGES = {"m7_double": ("double", "mps2-an500"), "m7_float": ("float", "mps2-an500"),
          "m7_float_small": ("float", "mps2-an500"), "m4_float": ("float", "mps2-an386")}
# Bytes that the code of a driver may have.
DRIVERS = {"driver_O2": 46 * 1024, "driver_small": 24 * 1024, "driver_Os": 24 * 1024}
WORST = 6000  # instructions that an update in float may take
FIGURES = ("update", "worst", "guard", "worst_guard")


def output_of(*command):
    """What a program prints. QEMU prints for the firmware on its standard error."""
    return subprocess.run([str(part) for part in command], check=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, timeout=120).stdout


def read(lines):
    """{stroke: {figure: text}}"""
    strokes = {}
    for line in lines.splitlines():
        name, *rest = line.split()
        if rest[:1] == ["hash"]:
            strokes[name] = dict(zip(rest[::2], rest[1::2]))
    return strokes


def emulate(board, image):
    return read(output_of("qemu-system-arm", "-M", board, "-nographic", "-monitor", "none", "-serial", "none",
                          "-semihosting-config", "enable=on,target=native", "-icount", "shift=10", "-kernel", image))


def size_of(image):
    """Bytes in flash without the ground: code, constants and what initialises data."""
    text, data = (int(number) for number in output_of("arm-none-eabi-size", image).splitlines()[1].split()[:2])
    symbols = output_of("arm-none-eabi-nm", "-CS", image)
    return text + data - int(re.search(r"^\w+ (\w+) \w microcontroller::ground$", symbols, re.MULTILINE)[1], 16)


def unwanted(image, scalar):
    """Symbols of a heap, and in float those of routines for doubles."""
    symbols = output_of("arm-none-eabi-nm", "-C", image)
    heap = re.findall(r" (_?malloc_r|malloc|_?sbrk|operator new.*)$", symbols, re.MULTILINE)
    doubles = re.findall(r" (__aeabi_(?:c?d\w+|f2d|u?i2d|u?l2d))$", symbols, re.MULTILINE)
    return heap + (doubles if scalar == "float" else [])


def check_bits(name, now, desktop):
    """Lines that say where a force differs from the desktop's."""
    wrong = [f"{name}: {set(now) ^ set(desktop)} only on one side"] if set(now) != set(desktop) else []
    for stroke in desktop:
        for figure in ("hash", "contacts", "trips"):
            here, there = now.get(stroke, {}).get(figure), desktop[stroke][figure]
            if here != there:
                wrong.append(f"{name}, {stroke}: {figure} is {here}, on the desktop {there}")
    return wrong


def compare(name, before, now):
    """Lines with the figures, and those that are too dear."""
    lines, wrong = [], []
    for stroke, figures in now.items():
        shown = []
        for figure, value in figures.items():
            old = before.get(stroke, {}).get(figure)
            shown.append(f"{value:6}" + (f" {100 * (value / old - 1) + 0.0:+6.2f} %" if old else " " * 9))
            if old and value > old * (100 + ALLOWED) / 100:
                wrong.append(f"{name}, {stroke}: {figure} {value}, stored {old}")
        lines.append(f"{name:14} {stroke:14} " + " ".join(shown))
    return lines, wrong


def main():
    if len(sys.argv) != 4 or sys.argv[1] not in ("check", "update"):
        sys.exit(__doc__)
    file, directory = pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    stored = json.loads(file.read_text()) if file.exists() else {}
    build = output_of("arm-none-eabi-g++", "--version").splitlines()[0]
    before = stored.get(build, {})
    desktop = {scalar: read(output_of(directory / f"desktop_{scalar}")) for scalar in ("double", "float")}
    now, wrong = {}, []
    print(f"{'image':14} {'stroke':14} " + " ".join(f"{figure:15}" for figure in FIGURES))
    for name, (scalar, board) in IMAGES.items():
        image = directory / f"{name}.elf"
        strokes = emulate(board, image)
        wrong += check_bits(name, strokes, desktop[scalar])
        now[name] = {stroke: {figure: int(said[figure]) for figure in FIGURES} for stroke, said in strokes.items()}
        lines, dear = compare(name, before.get(name, {}), now[name])
        wrong += dear
        wrong += [f"{name}, {stroke}: worst {figures['worst']}, may be {WORST}" for stroke, figures in now[name].items()
                  if before and scalar == "float" and figures["worst"] > WORST]
        print("\n".join(lines))
        wrong += [f"{name}: the image has {symbol}" for symbol in unwanted(image, scalar)]
    for name, most in DRIVERS.items():
        image = directory / f"{name}.elf"
        size = size_of(image)
        print(f"{name:14} {size} bytes, may have {most}")
        wrong += [f"{name}: {size} bytes, may have {most}"] if before and size > most else []
        wrong += [f"{name}: the image has {symbol}" for symbol in unwanted(image, "float")]
    print(f"({build})" + ("" if before else ": no figures are stored for it, so instructions are NOT COMPARED"))
    if sys.argv[1] == "update":
        stored[build] = now
        file.write_text(json.dumps(dict(sorted(stored.items())), indent=1) + "\n")
    elif wrong:
        sys.exit("\n".join(wrong))


if __name__ == "__main__":
    main()
