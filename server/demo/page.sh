# shellcheck shell=bash disable=SC2154  # part of demo.sh, which sets the variables
# --page: hapticd serves browsers, too.

page_address() {  # the newest one, with a token that was not used yet
  sed -n 's/.* page: \(http[^ ]*\) .*/\1/p' "$folder/hapticd.log" | tail -n 1
}

# A picture of the page, if there is a browser; then an address for people.
show_page() {
  local browser used
  rm -f "$output/page.png"
  browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
  no_picture="there is no chromium here"
  if [[ -n $browser ]]; then
    no_picture="the show ended before it could be taken"
    used=$(page_address)
    # After some seconds, in contact.
    node "$root/server/demo/page_picture.mjs" "$browser" "$folder/browser" "$used" 7.5 \
      "$output/page.png" >"$folder/browser.log" 2>&1 &
    running[browser]=$!
    for _ in {1..100}; do
      [[ $(page_address) != "$used" ]] && break
      sleep 0.1
    done
  fi
  echo
  echo "  open this page    $(page_address)"
  echo
  trap 'end_at=0' INT  # ends the show, and not the summary
}

page_summary() {
  if [[ -s $output/page.png ]]; then
    echo "  the page          $output/page.png"
  else
    if [[ -s $folder/browser.log ]]; then no_picture=$(tail -n 1 "$folder/browser.log"); fi
    echo "  the page          no picture: $no_picture"
  fi
}
