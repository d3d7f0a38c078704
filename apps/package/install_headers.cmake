# Installs the public headers of SOURCE below FOLDER, as forefeel/geometry/…: their includes of each other get the same
# prefix. Private are the headers that carry CGAL or SQLite along.
foreach(folder geometry solver approx scheduling)
  file(GLOB headers RELATIVE ${SOURCE} ${SOURCE}/${folder}/*/*.hpp)
  list(FILTER headers EXCLUDE REGEX "_cgal\\.hpp$|/(sqlite_handle|state_rows|hostile_file)\\.hpp$")
  foreach(header IN LISTS headers)
    file(READ ${SOURCE}/${header} text)
    string(REGEX REPLACE "#include \"(geometry|solver|approx|scheduling)/" "#include \"forefeel/\\1/" text "${text}")
    file(WRITE ${FOLDER}/${header} "${text}")
  endforeach()
endforeach()
file(READ ${SOURCE}/scheduling/forefeel.hpp text)
string(REGEX REPLACE "#include \"(geometry|solver|approx|scheduling)/" "#include \"forefeel/\\1/" text "${text}")
file(WRITE ${FOLDER}/forefeel.hpp "${text}")
file(READ ${SOURCE}/apps/main/command_main.hpp text)   # it includes nothing
file(WRITE ${FOLDER}/command.hpp "${text}")
message(STATUS "Installing: headers in ${FOLDER}")
