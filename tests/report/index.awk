# Turns tests/report/index.in into index.md: text as it stands, and two directives,
#
#   @figure NAME ALT TEXT...   a picture, with a link to its SVG; left out with a remark if not
#                              drawn
#   @table FILE [COLUMNS]      a CSV of the report as a table, all columns or those named (a,b,c)
#   @part NAME / @end          what stands between is left out unless the part NAME was made
#
# awk -v folder=DIR -v parts="kinematics fig4 ..." -f index.awk index.in
function exists(file,   line, found) {
  found = (getline line < file) >= 0
  close(file)
  return found
}
function shown(cell) {  # three significant digits for numbers, text as it is
  if (cell !~ /^-?[0-9.]+(e[-+]?[0-9]+)?$/) return cell
  if (cell + 0 == int(cell + 0) && length(cell) < 8) return cell
  return sprintf(cell + 0 >= 100 || cell + 0 <= -100 ? "%.0f" : "%.3g", cell)
}
function cells_of(line, cells,   n, quoted, i, c, cell) {  # a CSV line, quotes and all
  n = 0
  cell = ""
  quoted = 0
  for (i = 1; i <= length(line); i++) {
    c = substr(line, i, 1)
    if (c == "\"") {
      if (quoted && substr(line, i + 1, 1) == "\"") { cell = cell c; i++ }
      else quoted = !quoted
    } else if (c == "," && !quoted) {
      cells[++n] = cell
      cell = ""
    } else {
      cell = cell c
    }
  }
  cells[++n] = cell
  return n
}
function table(file, columns,   line, n, i, cells, wanted, count, head, rule, row) {
  count = 0
  while ((getline line < file) > 0) {
    n = cells_of(line, cells)
    if (count++ == 0) {
      for (i = 1; i <= n; i++) wanted[i] = columns == "" || index("," columns ",", "," cells[i] ",")
      head = rule = "|"
      for (i = 1; i <= n; i++) if (wanted[i]) { head = head " " cells[i] " |"; rule = rule "---|" }
      print head
      print rule
      continue
    }
    row = "|"
    for (i = 1; i <= n; i++) if (wanted[i]) row = row " " shown(cells[i]) " |"
    print row
  }
  close(file)
  if (count == 0) print "(" file " is missing)"
  delete wanted
}
$1 == "@part" { skip = index(" " parts " ", " " $2 " ") == 0; next }
$1 == "@end" { skip = 0; next }
skip { next }
$1 == "@table" { table(folder "/" $2, $3); next }
$1 == "@figure" {
  name = $2
  alt = $0
  sub(/^@figure +[^ ]+ */, "", alt)
  if (exists(folder "/" name ".svg")) print "[![" alt "](" name ".png)](" name ".svg)"
  else print "(" name " was not drawn in this run)"
  next
}
{ print }
