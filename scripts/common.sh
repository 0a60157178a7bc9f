# SPDX-License-Identifier: GPL-2.0-or-later
# Sourced by run, test and install: what they share. Every step is silent where nothing has to be done.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=${TALIK_BUILD:-$root/build}
python=/usr/bin/python3 # the interpreter of Debian's yade; another python3 may come first on the PATH

# For the loops of YADE's own engines; those of Talik wait as they see fit. A thread waits some 30 us for the others before it sleeps: as
# fast as without limit where nothing else runs, and not twenty times slower where something does.
[ -n "${OMP_WAIT_POLICY:-}" ] || export GOMP_SPINCOUNT=${GOMP_SPINCOUNT:-10000}

fail() {
	printf '%s: %s\n' "$(basename "$0")" "$*" >&2
	exit 1
}

note() {
	printf '%s\n' "$*" >&2
}

# needsValue $# "$1": refuses an option that is the last word.
needsValue() { [ "$1" -ge 2 ] || fail "$2 needs a value"; }

# The whole path of the folder of --output, made if need be.
writableOutput() {
	mkdir -p "$1" 2>/dev/null && [ -w "$1" ] || fail "cannot write into $1; choose another folder with --output"
	cd "$1" && pwd
}

packageLists=("$root/scripts/packages.txt")
neededPackages() {
	sed -e 's/#.*//' -e '/^[[:space:]]*$/d' "${packageLists[@]}"
}

missingPackages() {
	local installed
	installed=$(dpkg-query -W -f='${Package} ${db:Status-Status}\n' 2>/dev/null | awk '$2 == "installed" { print $1 }' | sort -u)
	neededPackages | sort -u | comm -23 - <(printf '%s\n' "$installed")
}

# failWithLog what log: shows the end of what a command said.
failWithLog() {
	tail -n 60 "$2" >&2
	fail "$1 failed; everything it said is in $2"
}

# Shows what a long command is doing in one line, and its whole output only if it fails.
quietly() {
	local what=$1 log=$2
	shift 2
	mkdir -p "$(dirname "$log")"
	"$@" >"$log" 2>&1 || failWithLog "$what" "$log"
}

# The same of a build, and how far it is: a line for every tenth that had to be compiled, none where nothing had.
showingProgress() {
	local what=$1 log=$2
	shift 2
	mkdir -p "$(dirname "$log")"
	"$@" 2>&1 | tee "$log" | tenthsBuilt || failWithLog "$what" "$log"
}

# Not with awk: Debian's reads a pipe in blocks, and would tell everything at the end.
tenthsBuilt() {
	local line tenth shown=0
	while IFS= read -r line; do
		[[ $line =~ ^\[\ *([0-9]+)%\]\ Building ]] || continue
		tenth=$((BASH_REMATCH[1] / 10))
		[ $tenth -le $shown ] || note "  $((10 * tenth)) % built"
		shown=$tenth
	done
}

ensurePackages() {
	command -v dpkg-query >/dev/null && command -v apt-get >/dev/null ||
		fail "Talik needs Debian 12, 13 or testing (apt-get and dpkg-query were not found); the packages to provide by hand are in scripts/packages.txt"
	local missing become=() log
	missing=$(missingPackages | xargs)
	[ -z "$missing" ] && return
	if [ "$(id -u)" -ne 0 ]; then
		if command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
			become=(sudo)
		else
			fail "these packages are missing and only root can install them: $missing
Type  sudo apt-get install --no-install-recommends $missing  and start again."
		fi
	fi
	note "Installing $missing ..."
	log=$(mktemp -t talik-apt.XXXXXX)
	# A repository that is not Debian's may be unreachable; whether the packages can be had shows in the next command.
	"${become[@]}" apt-get update >"$log" 2>&1 || true
	quietly "apt-get install" "$log" "${become[@]}" env DEBIAN_FRONTEND=noninteractive \
		apt-get install -y --no-install-recommends $missing
	rm -f "$log"
}

ensureYade() {
	local version
	version=$(dpkg-query -W -f='${Version}' yade 2>/dev/null)
	case $version in
	2023.02a* | 2025.2.0* | 2026.1.0*) ;;
	*) fail "Talik is built for yade 2023.02a, 2025.2.0 or 2026.1.0 (Debian 12, 13 and testing); yade here is '${version:-absent}'" ;;
	esac
}

# What cmake noted in the folder of another clone, or of one that was moved, is of no use.
dropForeignBuild() {
	local cache=$build/CMakeCache.txt
	[ -f "$cache" ] || return 0
	grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$cache" && return
	note "$build was built from $(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$cache"), not from $root: it is built anew."
	rm -rf "$cache" "$build/CMakeFiles" "$build/Makefile"
}

# Where ccache is installed, a copy of a tree finds what was compiled for the other one.
compilerLauncher() { ! command -v ccache >/dev/null || printf '%s' "-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"; }
export CCACHE_BASEDIR=$root CCACHE_NOHASHDIR=1

# ensureBuilt [target]...: everything, or only these targets of CMake.
ensureBuilt() {
	local target=()
	[ $# -gt 0 ] && target=(--target "$@")
	mkdir -p "$build" 2>/dev/null && [ -w "$build" ] || fail "cannot write into $build; set TALIK_BUILD to a folder that is yours"
	dropForeignBuild
	if [ ! -f "$build/CMakeCache.txt" ] || [ ! -f "$build/Makefile" ]; then
		note "Building Talik for the first time (a few minutes) ..."
		quietly "cmake" "$build/configure.log" cmake -S "$root" -B "$build" -G "Unix Makefiles" -DCMAKE_BUILD_TYPE=Release \
			$(compilerLauncher) ${TALIK_WARNINGS_ARE_ERRORS:+-DTALIK_WARNINGS_ARE_ERRORS=ON}
	fi
	showingProgress "the build" "$build/build.log" cmake --build "$build" -j "$(nproc)" "${target[@]}"
	tellWarnings "$build/build.log"
}

tellWarnings() {
	local number
	number=$(grep -c 'warning:' "$1" || true)
	[ "$number" = 0 ] || note "Warnings of the compiler: $number; they are in $1"
}

# Packages, the right YADE, and an up-to-date build.
ensureReady() {
	ensurePackages
	ensureYade
	ensureBuilt "$@"
	export PYTHONPATH=$build/python${PYTHONPATH:+:$PYTHONPATH}
}
