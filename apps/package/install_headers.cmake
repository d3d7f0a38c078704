# Installs the public headers of SOURCE below FOLDER, as forefeel/geometry/…: the umbrella header, those that its
# comment names ("//   FOLDER/FILE.hpp  …"), and all that they include. Their includes of each other get the same
# prefix.
cmake_policy(VERSION 3.25)
set(include_line "#include \"((geometry|solver|approx|scheduling)/[^\"]*)\"")
set(named_line "//   ((geometry|solver|approx|scheduling)/[a-z_/]+\\.hpp) ")

# Writes a header with its prefixes to TARGET.
function(install_header header target)
  file(READ ${SOURCE}/${header} text)
  string(REGEX REPLACE "${include_line}" "#include \"forefeel/\\1\"" text "${text}")
  file(WRITE ${FOLDER}/${target} "${text}")
endfunction()

# Sets `result` to the first groups of all matches of a pattern in a header.
function(paths_in header pattern result)
  file(STRINGS ${SOURCE}/${header} lines REGEX "${pattern}")
  list(TRANSFORM lines REPLACE ".*${pattern}.*" "\\1")
  set(${result} ${lines} PARENT_SCOPE)
endfunction()

set(umbrella scheduling/forefeel.hpp)
paths_in(${umbrella} "${include_line}" open)
paths_in(${umbrella} "${named_line}" named)
list(APPEND open ${named})
set(done)
while(open)
  list(POP_FRONT open header)
  if(NOT header IN_LIST done)
    list(APPEND done ${header})
    install_header(${header} ${header})
    paths_in(${header} "${include_line}" included)
    list(APPEND open ${included})
  endif()
endwhile()
install_header(${umbrella} forefeel.hpp)
install_header(apps/main/command_main.hpp command.hpp)
install_header(apps/session/read_scene.hpp scene.hpp)
list(LENGTH done count)
message(STATUS "Installing: ${count} headers in ${FOLDER}")
