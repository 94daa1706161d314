#!/bin/sh
# No two files of one folder of tests define the same name at their outermost level: the release
# preset compiles the folder as one unit, in which the second would be refused or, worse, hide or
# overload the first. The check is lexical: a definition begins in the first column. Aliases may
# repeat; the compiler refuses them if they differ.
#
#   test_names.sh ROOT
set -eu
root=${1:?the folder of the project}
here=$(cd "$(dirname "$0")" && pwd)
. "$here/files.sh"
cd "$root"
files_of . | grep -E '^tests/.*\.(cpp|hpp)$' | grep -vE '^tests/(bench|report|package)/' |
  while read -r file; do
  [ -f "$file" ] || continue
  awk -v file="$file" '
    function told(name) { if (!(name in seen)) { seen[name] = 1;
      print folder "\t" name "\t" base } }
    BEGIN { n = split(file, part, "/"); base = part[n]; folder = substr(file, 1,
      length(file) - length(base) - 1) }
    /^(class|struct|union|enum|enum class) +[A-Za-z_0-9]+(;|::)/ { next }
    /^(class|struct|union|enum|enum class) +[A-Za-z_0-9]+/ {
      line = $0; sub(/^enum class /, "enum ", line); split(line, word, /[ :;{<(]+/); told(word[2]);
        next
    }
    /^(TEST|INSTANTIATE|using|namespace|return|template|extern|public|private|protected)/ { next }
    /^[A-Za-z_][A-Za-z_0-9:<>,&* ]*[ &*][A-Za-z_0-9]+(\[\])*(\(| =|\{|;)/ {
      line = $0; sub(/(\[\])*(\(| =|\{|;).*/, "", line)
      sub(/.*[ &*]/, "", line); if (line !~ /:/) told(line)
    }' "$file"
done | sort | awk -F'\t' '
  $1 == folder && $2 == name {
    # A declaration in a header and its definition in the source of that name are one.
    one = base; other = $3; sub(/\.[a-z]+$/, "", one); sub(/\.[a-z]+$/, "", other)
    if (one != other) { print $1 ": " name " in " base " and in " $3; failed = 1 }
  }
  { folder = $1; name = $2; base = $3 }
  END { exit failed }'
