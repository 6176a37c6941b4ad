"""Builds the Python types of a ROS 2 package from its .msg, .srv and .action files.

Arguments: the directory of the package, and where to put the result, to be used as PYTHONPATH.
ROS's own generators write the code, as in `colcon build`; only CMake is done without.
"""

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

os.environ["AMENT_PREFIX_PATH"] = sys.prefix

import numpy
from rosidl_generator_c.cli import GenerateC
from rosidl_generator_py.cli import GeneratePython
from rosidl_typesupport_c.cli import GenerateCTypesupport
from rosidl_typesupport_fastrtps_c.cli import GenerateFastRTPSCTypesupport
from rosidl_typesupport_introspection_c.cli import GenerateIntrospectionCTypesupport

FASTRTPS, INTROSPECTION = "rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c"

package, out = (Path(argument).resolve() for argument in sys.argv[1:])
name, prefix, place = package.name, Path(sys.prefix), out / package.name
files = [path for path in package.glob("*/*") if path.suffix in (".msg", ".srv", ".action")]
given = {
    "package_name": name,
    "interface_files": sorted(f"{package}:{path.relative_to(package)}" for path in files),
    "include_paths": [str(prefix / "share")],
}
# Two generators write files of the same names.
apart = out / "introspection" / name
GenerateC("c").generate(output_path=place, **given)
GenerateFastRTPSCTypesupport("fastrtps").generate(output_path=place, **given)
GenerateIntrospectionCTypesupport("introspection").generate(output_path=apart, **given)
both = [FASTRTPS, INTROSPECTION]
GenerateCTypesupport("c", typesupport_implementations=both).generate(output_path=place, **given)
python = ["rosidl_typesupport_c"]
GeneratePython("py", typesupport_implementations=python).generate(output_path=place, **given)

includes = [out, out / "introspection", prefix / "include", numpy.get_include()]
includes += [sysconfig.get_path("include"), *(prefix / "include").iterdir()]
flags = ["-O0", "-w", "-fPIC", *(f"-I{path}" for path in includes)]


def compiled(sources):
    objects = []
    for source in sorted(sources):
        objects.append(source.with_name(source.name + ".o"))
        compiler = ["gcc"] if source.suffix == ".c" else ["g++", "-std=c++17"]
        subprocess.run([*compiler, *flags, "-c", source, "-o", objects[-1]], check=True)
    return objects


def link(library, objects, *others):
    """Adds links under the names by which ROS loads the libraries."""
    wanted = ("rcutils", "fastcdr", "rosidl_runtime_c", "rosidl_typesupport", "rosidl_generator")
    ros = [f"-l:{path.name}" for path in (prefix / "lib").glob("lib*.so")
           if any(part in path.name for part in wanted)]
    paths = [f"-L{place}", f"-L{prefix / 'lib'}", f"-Wl,-rpath,$ORIGIN:{prefix / 'lib'}"]
    subprocess.run(["g++", "-shared", f"-Wl,-soname,{library}", "-o", place / library, *objects,
                    *paths, "-Wl,--no-as-needed", *others, "-Wl,--as-needed", *ros], check=True)
    return f"-l:{library}"


sources = [path for path in place.rglob("*") if path.suffix in (".c", ".cpp")]
bindings = [path for path in sources if path.name.startswith("_")]
types = link(f"lib{name}__{FASTRTPS}.so", compiled(set(sources) - set(bindings)))
shapes = link(f"lib{name}__{INTROSPECTION}.so", compiled(apart.rglob("*.c")), types)
module = f"{name}_s__rosidl_typesupport_c{sysconfig.get_config_var('EXT_SUFFIX')}"
link(module, compiled(bindings), types, shapes)
