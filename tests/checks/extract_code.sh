#!/bin/sh
# Prints the first, or the NUMBERth, fenced code block of a language in a Markdown file.
#
#   extract_code.sh FILE LANGUAGE [NUMBER]
set -eu
awk -v fence="\`\`\`$2" -v number="${3:-1}" '
  $0 == fence && ++count == number { inside = 1; next }
  inside && /^```/ { inside = 0 }
  inside { print }
  END { exit count < number }' "$1"
