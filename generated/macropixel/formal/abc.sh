#!/bin/sh
# Made by  goldtof emit macropixel.toml (goldtof 0.1.0)
#
# ABC as sby calls it, with -c and its commands, for whoever has Debian's berkeley-abc, or the
# yosys-abc of an older Yosys, and not sby's own. In the folder of the design:
#   sby --abc "sh '$PWD/formal/abc.sh'" -f formal/NAME.sby
abc=$(command -v berkeley-abc || command -v yosys-abc) || {
    echo "neither berkeley-abc nor yosys-abc is installed" >&2
    exit 127
}
# pdr of these has no option -l, which only prints more.
commands=$(printf '%s' "$2" | sed 's/pdr -v -l/pdr -v/')
status=0
"$abc" "$1" "$commands" || status=$?
# They leave out the line break before the end of a counterexample.
sed -i 's/\([01]\)# DONE$/\1\n# DONE/' engine_*/trace*.aiw 2>/dev/null || true
exit "$status"
