#!/bin/sh
# A recipe gives the committed mesh again, to the byte. usage: remake_mesh.sh TREMOLO_MESH NAME MESH
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$1" "$2" -o "$work/remade.msh"
cmp "$work/remade.msh" "$3"
