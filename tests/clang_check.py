"""What clang has to say about every file, each alone and with all warnings (preset develop); nothing is linked.

  python3 tests/clang_check.py        the files that changed since the commit that was last green, and those that include
                                      a changed header; the commit is kept in $XDG_CACHE_HOME/forefeel
  python3 tests/clang_check.py all    every file
"""
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

SOURCE = pathlib.Path(__file__).resolve().parent.parent
BUILD = SOURCE / "build" / "develop"
DOOR = {"forefeel/forefeel.hpp": "scheduling/forefeel.hpp", "forefeel/command.hpp": "apps/main/command_main.hpp",
        "forefeel/scene.hpp": "apps/session/read_scene.hpp"}
STAMP = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "forefeel" / "clang-green"


def git(*words):
    return subprocess.run(["git", "-C", SOURCE, *words], capture_output=True, text=True)


def last_green():
    """The commit that was last green, the compiler's version, and the files that were checked."""
    try:
        return json.loads(STAMP.read_text())
    except (OSError, ValueError):
        return {}


def version():
    return subprocess.run(["clang++-14", "--version"], capture_output=True, text=True).stdout.splitlines()[0]


def changed(green):
    """Names of files that differ from the last green commit; None: not known, or how files are compiled changed."""
    difference = git("diff", "--name-only", green["commit"]) if green.get("clang") == version() else None
    if difference is None or difference.returncode != 0:
        return None
    names = set(difference.stdout.split()) | set(git("ls-files", "--others", "--exclude-standard").stdout.split())
    generated = ("CMakeLists.txt", "CMakePresets.json", ".cmake", ".in", ".js", ".css", ".html")
    return None if any(name.endswith(generated) for name in names) else names


def includers(names):
    """These files and all that include them, directly or not."""
    files = [name for name in git("ls-files", "--cached", "--others", "--exclude-standard", "*.cpp", "*.hpp").stdout.split()
             if (SOURCE / name).exists()]
    by_name = {}   # "geometry/common/types.hpp" or "small_body.hpp" -> files that include it
    for file in files:
        for included in re.findall(r'^#include ["<]([^">]+)[">]', (SOURCE / file).read_text(), re.M):
            by_name.setdefault(DOOR.get(included, included), []).append(file)
    found, open_ = set(names), list(names)
    while open_:
        name = open_.pop()
        for file in by_name.get(name, []) + by_name.get(name.rsplit("/", 1)[-1], []):
            if file not in found:
                found.add(file)
                open_.append(file)
    return found


def check(command):
    words = shlex.split(command["command"])
    at = words.index("-o")
    words[at:at + 2] = []
    words[words.index("-c")] = "-fsyntax-only"
    done = subprocess.run(words, cwd=command["directory"], capture_output=True, text=True)
    return done.returncode, done.stderr


def main():
    subprocess.run(["cmake", "--preset", "develop"], cwd=SOURCE, check=True, stdout=subprocess.DEVNULL)
    targets = subprocess.run(["ninja", "-C", BUILD, "-t", "targets", "all"], check=True, capture_output=True, text=True)
    headers = re.findall(r"^(\S*cmake_pch\.hxx\.pch):", targets.stdout, re.M)
    subprocess.run(["ninja", "-C", BUILD, "apps/generated/apps/build_info.hpp", *headers], check=True, stdout=subprocess.DEVNULL)
    commands = [one for one in json.loads((BUILD / "compile_commands.json").read_text())
                if one["file"].endswith(".cpp") and "cmake_pch" not in one["file"]]
    files = [os.path.relpath(one["file"], SOURCE) for one in commands]
    green = last_green()
    names = None if sys.argv[1:] == ["all"] else changed(green)
    if names is not None:
        wanted = includers(names) | set(files) - set(green["files"])   # what was not configured then
        commands = [one for one, file in zip(commands, files) if file in wanted]
    print(f"clang: {len(commands)} files" + ("" if names is None else f", changed since {green['commit'][:12]}"))
    bad = 0
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for code, text in pool.map(check, commands):
            sys.stderr.write(text)
            bad += code != 0
    if bad:
        sys.exit(f"clang: {bad} files with warnings or errors")
    if not git("status", "--porcelain").stdout:
        STAMP.parent.mkdir(parents=True, exist_ok=True)
        STAMP.write_text(json.dumps({"commit": git("rev-parse", "HEAD").stdout.strip(), "clang": version(), "files": files}))


main()
