#!/bin/sh
# The positive control of the small checks: each passes a good tree and catches a bad one.
#
#   checks_test.sh SCRATCH-FOLDER
set -eu
here=$(cd "$(dirname "$0")" && pwd)
scratch=${1:?a scratch folder}
. "$here/../support/scratch.sh"
failures=0

# expect STATUS CHECK ARGUMENT
expect() {
  status=0
  case $2 in
    *.py) python3 "$here/$2" "$3" >"$scratch.log" 2>&1 || status=$? ;;
    *) sh "$here/$2.sh" "$3" >"$scratch.log" 2>&1 || status=$? ;;
  esac
  if [ "$status" -ne "$1" ]; then
    echo "FAILED: $2: expected status $1, got $status"
    cat "$scratch.log"
    failures=1
  fi
}

fresh_folder "$scratch"
mkdir -p "$scratch/core" "$scratch/docs"
# A repository of its own, so that the scratch folder's files are not those of the project around
# it.
git -C "$scratch" init -q 2>/dev/null || true

echo 'int a;' >"$scratch/core/a.cpp"
printf '# A b, c\nSee [the code](../core/a.cpp#L1), [it](#a-b-c), [the web](%s).\n' \
  https://github.com/x >"$scratch/docs/a.md"
expect 0 file_length "$scratch"
expect 0 no_machine_names "$scratch"
expect 0 references.py "$scratch"

yes 'int x;' | head -n 301 >"$scratch/core/long.cpp"
expect 1 file_length "$scratch"
mkdir "$scratch/tests"
mv "$scratch/core/long.cpp" "$scratch/tests"
expect 0 file_length "$scratch"
rm -r "$scratch/tests"

expect 0 columns.py "$scratch"
words=$(yes word | head -n 25 | tr '\n' ' ') # 125 columns
printf '| %s|\n\n```\n%s\n```\n' "$words" "$words" >"$scratch/docs/b.md"
expect 0 columns.py "$scratch"
echo "$words" >"$scratch/docs/b.md"
expect 1 columns.py "$scratch"
rm "$scratch/docs/b.md"

words=$(yes word | head -n 45 | tr '\n' ' ')
printf 'Long, %s\nand its end.\n' "$words" >"$scratch/docs/b.md"
expect 1 plain_english.py "$scratch"
printf -- '- %s\n- Items.\n\n| %s%s |\n' "$words" "$words" "$words" >"$scratch/docs/b.md"
expect 0 plain_english.py "$scratch"
rm "$scratch/docs/b.md"
for word in O''f B''y A''s W''hat W''hether; do
  printf 'int a;  // %s course.\n' "$word" >"$scratch/core/b.cpp"
  expect 1 plain_english.py "$scratch"
done
printf '// A part. Of course.\nint byte;  // of a part\n' >"$scratch/core/b.cpp"
expect 0 plain_english.py "$scratch"
rm "$scratch/core/b.cpp"

for line in 'open("/wo''rk/x");' 'path = /tm''p/socket' \
  'FROM registry https://mirror.example.net/x'; do
  echo "$line" >"$scratch/core/b.cpp"
  expect 1 no_machine_names "$scratch"
done
rm "$scratch/core/b.cpp"

mkdir -p "$scratch/tests/core"
printf '// A test.\nclass Bench {\n};\ndouble half(double x) {\n}\n' \
  >"$scratch/tests/core/a_test.cpp"
printf 'class Bench;\nusing A = B;\nint other() {\n}\n' >"$scratch/tests/core/b_test.cpp"
expect 0 test_names "$scratch"
for line in 'struct Bench {' 'VecX half(const VecX& x) {' 'constexpr double half = 0.5;' \
  'const int half[] = {1};'; do
  echo "$line" >"$scratch/tests/core/c_test.cpp"
  expect 1 test_names "$scratch"
done
rm "$scratch"/tests/core/*
echo 'TEST(A, HoldsForceFor200MsByTCP) {' >"$scratch/tests/core/a_test.cpp"
expect 1 rule_names.py "$scratch"
echo 'TEST_F(A, HoldsForce200MsByTCP) {' >"$scratch/tests/core/a_test.cpp"
expect 0 rule_names.py "$scratch"
rm -r "$scratch/tests"

echo '// docs/a''.md#a-b-c' >"$scratch/core/b.cpp"
expect 0 references.py "$scratch"
for line in '// docs/a''.md#gone' '// gone''.md#a-b-c' '// METHOD'' 5.3' '// WIRE'' 4'; do
  echo "$line" >"$scratch/core/b.cpp"
  expect 1 references.py "$scratch"
done
rm "$scratch/core/b.cpp"
for line in '[gone](nowhere.md)' '[gone](a''.md#gone)' '| a table | `core/gone.cpp` |'; do
  echo "$line" >"$scratch/README.md"
  expect 1 references.py "$scratch"
  printf '```\n[code](of/others.md)\n```\n' >"$scratch/README.md"
  expect 0 references.py "$scratch"
done
rm "$scratch/README.md"

printf '# why\nrace:libgrpc\nrace:libabsl\nrace:libprotobuf\n' >"$scratch/tsan.supp"
expect 0 tsan_suppressions "$scratch/tsan.supp"
for rule in 'race:haptic::server' 'race:*' 'race:libgrpc_and_ours' 'thread:hapticd' 'race:std::'; do
  printf 'race:libgrpc\n%s\n' "$rule" >"$scratch/tsan.supp"
  expect 1 tsan_suppressions "$scratch/tsan.supp"
done
echo 'race:libssl' >"$scratch/tsan.supp"
sh "$here/tsan_suppressions.sh" "$scratch/tsan.supp" libssl >/dev/null ||
  { echo "FAILED: a library named"; failures=1; }

wire=$scratch/proto/wire/include/haptic/wire
mkdir -p "$wire" "$scratch/client/python/haptic"
printf 'int kGrpcPort = 29470;\nconst char* kDefaultServer = "127.0.0.1:29470";\n' |
  sed 's/^int/inline constexpr std::uint16_t/' >"$wire/ports.hpp"
echo 'DEFAULT_SERVER = "127.0.0.1:29470"' >"$scratch/client/python/haptic/_ports.py"
echo 'Connection("127.0.0.1:29470")' >"$scratch/client/page.md"
expect 0 ports "$scratch"
for wrong in 'Connection("127.0.0.1:29480")' 'EXPOSE 50052/udp'; do
  echo "$wrong" >"$scratch/client/page.md"
  expect 1 ports "$scratch"
done
rm "$scratch/client/page.md"
for copy in 'int port = 29470;' 'server("127.0.0.1:50051")'; do
  echo "$copy" >"$scratch/client/copy.cpp"
  expect 1 ports "$scratch"
done
rm "$scratch/client/copy.cpp"
echo 'DEFAULT_SERVER = "127.0.0.1:29479"' >"$scratch/client/python/haptic/_ports.py"
expect 1 ports "$scratch"

# fresh_folder never removes a folder that it did not make.
mkdir "$scratch/theirs" && echo precious >"$scratch/theirs/file"
if (fresh_folder "$scratch/theirs") 2>/dev/null || [ ! -s "$scratch/theirs/file" ]; then
  echo "FAILED: fresh_folder removed what it had not made"
  failures=1
fi
fresh_folder "$scratch"
expect 2 folder_circles.py "$scratch"
mkdir -p "$scratch/core/src/a" "$scratch/core/include/haptic/core/b" "$scratch/core/src/c"
echo '#include "haptic/core/b/b.hpp"' >"$scratch/core/src/a/a.cpp"
echo '#include "core/src/c/c.hpp"' >"$scratch/core/include/haptic/core/b/b.hpp"
echo '#include <array>' >"$scratch/core/src/c/c.hpp"
expect 0 folder_circles.py "$scratch"
echo '#include "haptic/core/a/a.hpp"' >>"$scratch/core/src/c/c.hpp"  # a -> b -> c -> a
expect 1 folder_circles.py "$scratch"
exit $failures
