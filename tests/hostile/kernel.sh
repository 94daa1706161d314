#!/usr/bin/env bash
# Attacks from inside the front on Debian 12's own kernel, which is older than many a host's: boots
# it in QEMU (no KVM, so no times are judged) with the built programs in its first file system, and
# prints a table. Fifteen minutes.
#
#   tests/hostile/kernel.sh [--build FOLDER] [--image PACKAGE]
#
# FOLDER: build/release by default, built before. PACKAGE: linux-image-cloud-amd64 by default; what
# it depends on is downloaded and unpacked below FOLDER, not installed. QEMU comes with
# docker/install-deps.sh kernel. Exit status 1 if a row failed, 77 without QEMU or package.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$root/build/release
image=linux-image-cloud-amd64
while (($#)); do
  case "$1" in
    --build) build=$(cd "${2:?--build needs a folder}" && pwd); shift 2 ;;
    --image) image=${2:?--image needs a package}; shift 2 ;;
    -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;;
    *) echo "kernel.sh: unknown argument '$1' (see --help)" >&2; exit 2 ;;
  esac
done
skip() { echo "kernel.sh: $*" >&2; exit 77; }
command -v qemu-system-x86_64 >/dev/null || skip "no QEMU: docker/install-deps.sh kernel"
work=$build/kernel/$image
mkdir -p "$work"
cd "$work"

if ! compgen -G 'boot/vmlinuz-*' >/dev/null; then
  name=$(apt-cache depends "$image" | sed -n 's/.*Depends: \(linux-image-[0-9].*\)/\1/p')
  apt-get -qq download "${name:-$image}" 2>/dev/null || skip "cannot download $image"
  for package in linux-image-*.deb; do dpkg-deb -x "$package" .; done
  rm -rf linux-image-*.deb usr lib
fi

# The first file system: programs, their libraries, Python, the suite.
rm -rf files
mkdir -p files/{dev,proc,sys,tmp,run,etc,suite,usr/bin,usr/lib,lib64}
for link in bin lib; do ln -s usr/$link files/$link; done
programs=("$build/server/hapticd" "$build/tests/haptic-front-attacker" "$build/client/hapticctl")
cp "${programs[@]}" "$(realpath /usr/bin/python3)" /usr/bin/setpriv files/usr/bin/
python=$(/usr/bin/python3 -c 'import sysconfig; print(sysconfig.get_path("stdlib"))')
cp -r "$python" files/usr/lib/
find files/usr/lib -name __pycache__ -prune -exec rm -r {} +
rm -rf files"${python}"/{test,idlelib,lib2to3,pydoc_data} files"${python}"/lib-dynload/_tkinter*
cp "$root"/tests/hostile/*.py files/suite/
install -m 755 "$root/tests/hostile/kernel_guest.py" files/init
sed -i "1c#!/usr/bin/$(basename "$(realpath /usr/bin/python3)")" files/init
printf 'root:x:0:0::/:/bin/sh\nnobody:x:65534:65534::/:/bin/sh\n' >files/etc/passwd
echo '127.0.0.1 localhost' >files/etc/hosts
printf 'root:*:1::::::\n' >files/etc/shadow
chmod 600 files/etc/shadow
{ ldd files/usr/bin/* files"${python}"/lib-dynload/*.so 2>/dev/null || true; } |
  grep -o '/[^ ]*[.]so[^ ]*' | grep -v ':$' | sort -u | while read -r library; do
    mkdir -p "files$(dirname "$library")"
    [[ -e files$library ]] || cp -L "$library" "files$library"
  done
(cd files && find . -print0 | cpio --null --create --format=newc --quiet) | gzip -1 >files.img
rm -rf files

timeout 2400 qemu-system-x86_64 -accel tcg,thread=multi -cpu max -smp 2 -m 2048 -nic none \
  -nographic -no-reboot -kernel boot/vmlinuz-* -initrd files.img \
  -append "console=ttyS0 quiet panic=-1" </dev/null | stdbuf -oL tr -d '\r' | tee console |
  sed -un 's/^.*row: //p'
grep -q '^.*row: 0 failed' console
