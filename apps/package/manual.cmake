# Writes forefeel.1 (manual page) and forefeel.bash (completion) into FOLDER, from what COMMAND --help says.
function(help_of result)
  execute_process(COMMAND ${COMMAND} ${ARGN} --help OUTPUT_VARIABLE text RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "forefeel ${ARGN} --help failed")
  endif()
  set(${result} "${text}" PARENT_SCOPE)
endfunction()

# As the manual's formatter wants it: no line is a request, and "-" stays what one types.
function(preformatted result text)
  string(REPLACE "\\" "\\e" text "${text}")
  string(REPLACE "-" "\\-" text "${text}")
  string(REGEX REPLACE "(^|\n)([.'])" "\\1\\\\&\\2" text "${text}")
  set(${result} ".nf\n${text}\n.fi\n" PARENT_SCOPE)
endfunction()

function(long_options result text)
  string(REGEX MATCHALL "--[a-z][a-z0-9-]+" words "${text}")
  list(REMOVE_DUPLICATES words)
  list(JOIN words " " words)
  set(${result} "${words}" PARENT_SCOPE)
endfunction()

help_of(top)
string(REGEX REPLACE "\n.*" "" summary "${top}")
string(REGEX REPLACE "^.*--version[^\n]*\n" "" listed "${top}")
string(REGEX MATCHALL "(^|\n)  [a-z]+ " names "${listed}")
list(TRANSFORM names STRIP)
if(NOT names)
  message(FATAL_ERROR "no command in: ${top}")
endif()

preformatted(text "${top}")
set(page ".TH FOREFEEL 1 \"\" \"forefeel ${VERSION}\" \"User commands\"\n.SH NAME\nforefeel \\- haptic rendering of soft bodies from states solved ahead of the hand\n")
string(APPEND page ".SH SYNOPSIS\n.B forefeel\n.I COMMAND\n[options]\n.SH DESCRIPTION\n${text}.SH COMMANDS\n")
set(cases "")
foreach(name IN LISTS names)
  help_of(help ${name})
  preformatted(text "${help}")
  string(APPEND page ".SS forefeel ${name}\n${text}")
  long_options(options "${help}")
  string(APPEND cases "    ${name}) words=\"${options}\" ;;\n")
endforeach()
string(APPEND page ".SH EXIT STATUS\n0: done. 1: ran, but the answer is negative or incomplete. 2: bad input.\n")
preformatted(text "The scenes and studies that were installed (PREFIX is /usr by the Debian package):
  share=PREFIX/share/forefeel
The force with the contact pressed in by 2 cm:
  forefeel solve $share/scenes/liver.toml --at=0,0,-0.02
A lattice of states, and a picture of what they cover:
  forefeel generate $share/scenes/liver.toml -o liver.states
  forefeel classify liver.states --grid 0.004 -o coverage.svg
A session of 5 s that gives the same bytes each time; a solve costs 50 ms:
  forefeel session $share/scenes/liver.toml --clock virtual --seconds 5 --device path:circle,speed=0.04 --cost constant:0.05 -o run
Policies compared over many sessions:
  forefeel study $share/studies/quick.toml -o study
What the cache holds, and emptying it:
  forefeel cache
  forefeel cache --empty")
string(APPEND page ".SH EXAMPLES\n${text}")
preformatted(text "$XDG_CACHE_HOME/forefeel, or else ~/.cache/forefeel
  The cache: meshes of phantoms, tight solves, measured spacings and costs. See forefeel cache.
RUN/summary.json, frames.csv, dispatch.csv, switches.csv, states.csv, session.states, report.html
  What a session writes. In frames.csv fx, fy, fz is the force sent to the device, rendered_x, rendered_y,
  rendered_z the force before the safety rules; error is that of the rendered force.
DIR/cells.csv, report.html, study.json, cells/
  What a study writes; cells/ holds the results that a rerun resumes from.
PREFIX/share/forefeel
  Scenes, studies and examples, where the package is installed.")
string(APPEND page ".SH FILES\n${text}")
file(WRITE ${FOLDER}/forefeel.1 "${page}")

long_options(options "${top}")
list(JOIN names " " names)
file(WRITE ${FOLDER}/forefeel.bash "# Completion of forefeel: commands, their options, and files.
_forefeel() {
  local word=\${COMP_WORDS[COMP_CWORD]} words
  if [ \"\$COMP_CWORD\" -eq 1 ]; then
    COMPREPLY=(\$(compgen -W \"${names} ${options}\" -- \"\$word\"))
    return
  fi
  case \${COMP_WORDS[1]} in
${cases}    *) words=\"\" ;;
  esac
  case \$word in
    -*) COMPREPLY=(\$(compgen -W \"\$words\" -- \"\$word\")) ;;
    *) COMPREPLY=(\$(compgen -f -- \"\$word\")) ;;
  esac
}
complete -o filenames -F _forefeel forefeel
")
