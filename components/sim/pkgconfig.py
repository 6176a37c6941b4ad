"""Writes mujoco.pc for pkg-config: ``python3 pkgconfig.py DIRECTORY``.

The wheel of MuJoCo (``pip install mujoco-core``) has its headers and its library, and no such file.
Run it with the interpreter that has the wheel.
"""

import glob
import importlib.util
import os
import re
import sys

_TEXT = """\
Name: mujoco
Description: Physics simulator
Version: {version}
Cflags: -isystem{place}/include
Libs: {library} -Wl,-rpath,{place}
"""


def main() -> None:
    found = importlib.util.find_spec("mujoco")
    places = [] if found is None else list(found.submodule_search_locations or [])
    libraries = [one for place in places for one in glob.glob(os.path.join(place, "libmujoco.so*"))]
    if not libraries:
        sys.exit("this interpreter has no MuJoCo: pip install mujoco-core")
    library = libraries[0]
    version = re.search(r"\.so\.([\d.]+)$", library)
    text = _TEXT.format(
        version=version.group(1) if version else "0",
        place=os.path.dirname(library),
        library=library,
    )
    os.makedirs(sys.argv[1], exist_ok=True)
    with open(os.path.join(sys.argv[1], "mujoco.pc"), "w", encoding="utf-8") as file:
        file.write(text)


if __name__ == "__main__":
    main()
