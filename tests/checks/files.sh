# shellcheck shell=sh Sourced by the checks: `files_of ROOT` prints the project's own files,
# relative to ROOT, one a line. From git if this is a repository (tracked and new files),
# otherwise from the folders.
files_of() {
  git -C "$1" ls-files --cached --others --exclude-standard 2>/dev/null ||
    (cd "$1" && find . -type f ! -path './build/*' ! -path './.git/*' ! -path './demo-output/*' \
      ! -path './report/*' | sed 's|^\./||')
}
