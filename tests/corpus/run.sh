#!/usr/bin/env bash
# run.sh [--short] [--packages short|all] BIN_DIR OUT_DIR [NAME...]: makes the corpus of awkward
# surfaces (--short: without the four that take longest and have a lesser one beside them), or takes
# those that Debian's packages ship (packages.tsv; `short` alone or all of them), gives each (or
# those named) to tremolo-mesh and prints a table. Exit code 77 if the packages are not
# installed; exit code 1 if one of them crashes, takes over 60 s of
# processor time or 600 s in all, succeeds with a mesh that nobody can use, fails without a message,
# or does other than its manifest expects.
# JOBS=2 runs two at a time.
set -u
usage="usage: run.sh [--short] [--packages short|all] BIN_DIR OUT_DIR [NAME...]"
packages= longest=
if [ "${1-}" = --short ]; then
  longest=" klein_bottle.ply everything.stl touching_edge.off repeated_turned.off "
  shift
fi
if [ "${1-}" = --packages ]; then
  packages=${2-}
  case $packages in short | all) ;; *) echo "$usage" >&2; exit 2 ;; esac
  shift 2
fi
[ $# -ge 2 ] || { echo "$usage" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
bin=$(cd "$1" && pwd) || exit 2
out=$2
shift 2
mkdir -p "$out" || exit 1
out=$(cd "$out" && pwd)
most=60

# Lines of name, what is the matter, expectation and path, with tabs between.
manifest=$out/manifest.tsv
if [ -z "$packages" ]; then
  "$bin/tremolo_make_surfaces" "$out/surfaces" >/dev/null || exit 1
  awk -F '\t' -v folder="$out/surfaces" '{ print $0 "\t" folder "/" $1 }' \
    "$out/surfaces/manifest.tsv" >"$manifest"
else
  data=/usr/share/doc/libcgal-dev/data.tar.gz
  for each in "$data" /usr/share/assimp/models /usr/share/glmark2/models; do
    [ -e "$each" ] && continue
    echo "$each is missing: apt-get install libcgal-demo assimp-testmodels glmark2-data" >&2
    exit 77
  done
  mkdir -p "$out/unpacked"
  tar xzf "$data" -C "$out/unpacked" data/meshes || exit 1
  awk -F '\t' -v which="$packages" -v cgal="$out/unpacked/data/meshes" '
    /^#/ || (which == "short" && $1 != "short") { next }
    {
      path = $3
      sub(/^cgal/, cgal, path)
      sub(/^(assimp|glmark2)/, "/usr/share/&/models", path)
      name = $3
      gsub("[/ ]", "_", name)
      print name "\t-\t" $2 "\t" path
    }' "$here/packages.tsv" >"$manifest"
fi

# one NAME EXPECTED PATH: its line of the table into NAME.row, and what is wrong into NAME.wrong.
one() {
  local name=$1 expected=$2 path=$3 seconds code wrong='' found=(- - - -) distance=- message
  local log=$out/$name.log mesh=$out/$name.msh
  rm -f "$mesh" "$out/$name.wrong"
  ulimit -t $((most + 5))  # of this background job alone
  {
    TIMEFORMAT='%U %S'
    time timeout --kill-after=5 $((10 * most)) "$bin/tremolo-mesh" "$path" \
      -o "$mesh" >"$out/$name.stdout" 2>"$log" </dev/null
    code=$?
  } 2>"$out/$name.time"
  seconds=$(awk 'NF == 2 { printf "%.1f", $1 + $2 }' "$out/$name.time")
  message=$(tail -n 1 "$log" | tr '\t' ' ')
  awk -v s="$seconds" -v most=$most 'BEGIN { exit !(s > most) }' && wrong="takes $seconds s"
  case $code in
    0)
      if read -r -a found < <("$bin/tremolo_check_mesh" "$mesh" 2>"$out/$name.check") &&
        [ "${found[0]}" -gt 0 ]; then :; else
        wrong="no usable mesh: $(cat "$out/$name.check")"
        found=(- - - -)
      fi
      distance=$(grep -o 'mesh to surface .*' "$log" | grep -o '([0-9.e+-]* %' | tr -d '(% ' | sort -g | tail -n 1)
      [ "$expected" = message ] && wrong='meshed, where only a message makes sense'
      ;;
    3)
      [ -n "$message" ] || wrong='no message'
      [ -e "$mesh" ] && wrong='a mesh in spite of the error'
      [ "$expected" = mesh ] && wrong='should be meshed'
      ;;
    124) wrong="takes over $((10 * most)) s" ;;
    152 | 137) wrong="takes over $most s" ;;
    *) wrong="exit code $code" ;;
  esac
  [ -n "$wrong" ] && printf '%s: %s\n' "$name" "$wrong" >"$out/$name.wrong"
  printf '%-34s %4s %6s %8s %6s %9s %5s %6s  %s\n' "$name" "$code" "$seconds" "${found[@]}" \
    "${distance:--}" "${message:0:160}" >"$out/$name.row"
}

printf '%-34s %4s %6s %8s %6s %9s %5s %6s  %s\n' \
  file code s tets angle volume parts 'off %' 'last line of the log'
names=()
while IFS=$'\t' read -r name what expected path; do
  if [ $# -gt 0 ]; then
    case " $* " in *" $name "*) ;; *) continue ;; esac
  fi
  case $longest in *" $name "*) continue ;; esac
  names+=("$name")
  while [ "$(jobs -rp | wc -l)" -ge "${JOBS:-1}" ]; do wait -n; done
  one "$name" "$expected" "$path" &
done <"$manifest"
wait
for name in "${names[@]}"; do cat "$out/$name.row"; done
wrong=0
for name in "${names[@]}"; do
  [ -e "$out/$name.wrong" ] || continue
  wrong=$((wrong + 1))
  cat "$out/$name.wrong"
done
echo "${#names[@]} surfaces, $wrong not as they should"
[ ${#names[@]} -gt 0 ] && [ $wrong = 0 ]
