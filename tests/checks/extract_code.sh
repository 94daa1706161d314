#!/bin/sh
# Prints the first fenced code block of a language in a Markdown file.
#
#   extract_code.sh FILE LANGUAGE
set -eu
awk -v fence="\`\`\`$2" '
  !found && $0 == fence { found = inside = 1; next }
  inside && /^```/ { inside = 0 }
  inside { print }
  END { exit !found }' "$1"
