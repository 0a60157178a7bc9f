# SPDX-License-Identifier: GPL-2.0-or-later
"""What scripts/run, test and install say while they build, with a cmake that only talks."""

import os
import subprocess
from pathlib import Path

import pytest

root = Path(__file__).resolve().parents[2]
cmake = """#!/bin/bash
if [ "$1" = --build ]; then {build}; else echo "$@" >"$TALIK_BUILD/asked"; touch "$TALIK_BUILD/Makefile"
echo "CMAKE_HOME_DIRECTORY:INTERNAL={root}" >"$TALIK_BUILD/CMakeCache.txt"; fi
"""
compiling = "for k in 4 8 11 35 38 72 100; do printf '[%3d%%] Building CXX object %d.o\\n' $k $k; done; echo '[100%] Built target all'"


@pytest.fixture
def built(tmp_path):
	"""Runs ensureBuilt in a folder of its own: (status, what was said)."""

	def run(build=compiling, launcher=False, environment={}):
		programs = tmp_path / "bin"
		programs.mkdir(exist_ok=True)
		for name, text in {"cmake": cmake.format(build=build, root=root), "ccache": "#!/bin/sh\n"}.items():
			(programs / name).write_text(text)
			(programs / name).chmod(0o755 if name == "cmake" or launcher else 0o644)
		inside = {**os.environ, **environment, "PATH": f"{programs}:/usr/bin:/bin", "TALIK_BUILD": str(tmp_path / "build")}
		script = f"set -euo pipefail; source {root}/scripts/common.sh; ensureBuilt"
		done = subprocess.run(["bash", "-c", script], env=inside, capture_output=True, text=True, timeout=60)
		return done.returncode, done.stderr

	return run


def test_a_build_tells_every_tenth_that_it_compiles(built):
	status, said = built()
	print(said)
	assert status == 0
	assert said.splitlines() == ["Building Talik for the first time (a few minutes) ...", *(f"  {percent} % built" for percent in (10, 30, 70, 100))]


def test_a_tenth_is_told_when_it_is_compiled_not_at_the_end(tmp_path):
	# the next one is compiled only when somebody has read of the first
	told = tmp_path / "told"
	os.mkfifo(told)
	waiting = "echo '[ 50%] Building CXX object 1.o'; read -t 30 <>" + str(told) + " || exit 3; echo '[100%] Building CXX object 2.o'"
	script = (
		f"set -euo pipefail; source {root}/scripts/common.sh; showingProgress 'the build' {tmp_path}/log bash -c \"{waiting}\" 2> "
		f">(while read -r line; do echo $line; [ \"$line\" != '50 % built' ] || echo go >{told}; done)"
	)
	done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, timeout=60)
	print(done.stdout + done.stderr)
	assert done.returncode == 0


def test_a_build_that_has_nothing_to_compile_is_silent(built):
	built()
	assert built(build="echo '[100%] Built target all'") == (0, "")


def test_a_build_of_a_copied_tree_says_why_it_is_made_anew(built, tmp_path):
	built()
	(tmp_path / "build" / "CMakeCache.txt").write_text("CMAKE_HOME_DIRECTORY:INTERNAL=/home/somebody/talik\n")
	status, said = built()
	print(said.splitlines()[0])
	assert status == 0 and said.startswith(f"{tmp_path}/build was built from /home/somebody/talik, not from {root}: it is built anew.\nBuilding Talik")


def test_a_build_that_fails_shows_its_end_and_names_its_log(built, tmp_path):
	status, said = built(build="echo 'x.cpp:3: error: no such name'; exit 2")
	print(said)
	assert status == 1 and "x.cpp:3: error: no such name" in said and f"the build failed; everything it said is in {tmp_path}/build/build.log" in said


def test_a_compile_that_warns_fails_the_build_of_the_fresh_clone(built, tmp_path):
	status, _ = built(environment={"TALIK_WARNINGS_ARE_ERRORS": "1"})
	asked = (tmp_path / "build" / "asked").read_text()
	assert status == 0 and "-DTALIK_WARNINGS_ARE_ERRORS=ON" in asked and "TALIK_WARNINGS_ARE_ERRORS=1" in (root / ".ci/run").read_text()
	project = tmp_path / "project"
	project.mkdir()
	(project / "warns.cpp").write_text("int main() { int unused; }\n")
	flags = next(line for line in (root / "CMakeLists.txt").read_text().splitlines() if line.startswith("add_compile_options(-Wall"))
	given = "cmake_minimum_required(VERSION 3.16)\nproject(warns CXX)\n" + flags + "\nadd_executable(warns warns.cpp)\n"
	(project / "CMakeLists.txt").write_text(given)
	for value, wanted in (("ON", False), ("OFF", True)):
		subprocess.run(["cmake", "-S", project, "-B", project / value, f"-DTALIK_WARNINGS_ARE_ERRORS={value}"], check=True, capture_output=True)
		done = subprocess.run(["cmake", "--build", project / value], capture_output=True, text=True)
		print(f"warnings are errors {value}: {done.returncode}")
		assert "unused variable" in done.stdout + done.stderr and (done.returncode == 0) == wanted


def test_where_ccache_is_installed_it_compiles(built, tmp_path):
	status, _ = built(launcher=True)
	assert status == 0 and "-DCMAKE_CXX_COMPILER_LAUNCHER=ccache" in (tmp_path / "build" / "asked").read_text()


def test_a_build_tells_how_often_the_compiler_warned(built, tmp_path):
	warning = "x.cpp:3: warning: unused variable"
	status, said = built(build=f"{compiling}; echo '{warning}'; echo '{warning}' >&2")
	print(said)
	assert status == 0 and said.splitlines()[-1] == f"Warnings of the compiler: 2; they are in {tmp_path}/build/build.log"


def test_run_takes_a_script_of_the_users_with_its_arguments(tmp_path):
	programs, build = tmp_path / "bin", tmp_path / "build"
	programs.mkdir()
	build.mkdir()
	for name, text in {"cmake": cmake.format(build="true", root=root), "yade": '#!/bin/sh\necho "$PYTHONPATH:" "$@"\n'}.items():
		(programs / name).write_text(text)
		(programs / name).chmod(0o755)
	(tmp_path / "my script.py").write_text("import talik\n")
	environment = {**os.environ, "PATH": f"{programs}:/usr/bin:/bin", "TALIK_BUILD": str(build), "PYTHONPATH": ""}
	told = {}
	for arguments in (["my script.py", "--preset", "mine", "-j3", "x y"], [str(root / "examples" / "barrier.py"), "-j1", "--output", str(tmp_path)], ["no.py"]):
		done = subprocess.run([root / "scripts" / "run", *arguments], env=environment, capture_output=True, text=True, timeout=60, cwd=tmp_path)
		told[arguments[0]] = (done.returncode, done.stdout.strip() or done.stderr.strip())
	print(*told.values(), sep="\n")
	assert told["my script.py"] == (0, f"{build}/python: -n -x -j 3 {tmp_path}/my script.py --preset mine x y")
	assert f"-j 1 {root}/examples/barrier.py --preset draft --output {tmp_path}" in told[str(root / "examples" / "barrier.py")][1]
	assert told["no.py"][0] == 1 and "there is no example 'no'" in told["no.py"][1] and told["no.py"][1].endswith("and no such file")
