# Style of every figure of the report. Each draws twice, as SVG and as PNG:
#
#   do for [kind in "svg png"] { eval begin(kind, width, height); ...; unset output }
#
# The caller sets csv (its data), output (path without ending) and, where it likes, heading.

if (!exists("font")) font = "DejaVu Sans"
if (!exists("heading")) heading = ""
set encoding utf8
set datafile separator ","
set datafile missing "nan"

methods = "standard null_space subspace_linear subspace_exact"
titles = "'standard, Eq. (1)' 'null-space, Eq. (3)-(4)' " \
  . "'subspace linear, Eq. (8)' 'subspace exact, Eq. (6)'"
hues = "#8a8f98 #8e5bb5 #1f6fb4 #2a9d5c"
alarm = "#c8283c"; alarm_shade = "#fbe3e5"; dark = "#404040"; blue = "#1f6fb4"; orange = "#d9660a"
hue(i) = word(hues, i)
# Not in brackets where it is used: `dashtype (` begins a pattern.
dashed(yes) = yes ? 2 : 1

# The PNG has 1.5 times the points, and a font and lines to match.
begin(kind, width, height) = (kind eq "svg" \
  ? sprintf("set terminal svg size %d,%d font '%s,13' background 'white' enhanced dynamic", width, \
    height, font) \
  : sprintf("set terminal pngcairo size %d,%d font '%s,15' background 'white' enhanced " \
            . "linewidth 1.4", \
            width * 3 / 2, height * 3 / 2, font)) \
  . sprintf("; set output '%s.%s'", output, kind)

# The methods' names in their colours in one row at the figure's foot: a key would wrap to its
# panel. Set before the first panel, `eval foot_off` after it.
foot_at(left, i) = sprintf("set label %d '%s' at screen %f, screen 0.03 textcolor rgb '%s'; ", \
  10 + i, \
  "━━ ".word(titles, i), left + (i - 1) * (1 - left) / 4, hue(i))
foot(left) = foot_at(left, 1).foot_at(left, 2).foot_at(left, 3).foot_at(left, 4)
foot_off = "do for [i = 11:14] { unset label i }"

# Column v where the row is of method m, else nothing.
of(m, v) = strcol("method") eq m ? v : NaN

set border 3 linecolor rgb dark front
set tics nomirror out scale 0.5
set grid xtics ytics linecolor rgb "#d4d8dd" linewidth 0.6 linetype 1 back
set key noautotitle samplen 2 spacing 1.2
set style fill solid 1.0 noborder
