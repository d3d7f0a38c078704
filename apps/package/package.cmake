# What `cmake --install` installs and what `cpack` packs: the command with its manual, the library with its headers,
# and the scenes, studies and examples to copy.
include(GNUInstallDirs)
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME forefeel)
set(package_folder ${PROJECT_SOURCE_DIR}/apps/package)

# One archive of the four libraries, for `find_package(forefeel)` and the target forefeel::forefeel.
set(library_objects)
foreach(folder geometry solver approx scheduling)
  list(APPEND library_objects $<TARGET_OBJECTS:forefeel_${folder}>)
endforeach()
foreach(name kernels approx)
  get_property(objects GLOBAL PROPERTY FOREFEEL_OBJECTS_${name})
  list(APPEND library_objects ${objects})
endforeach()
find_package(SQLite3 REQUIRED)
add_library(forefeel_library STATIC ${library_objects})
set_target_properties(forefeel_library PROPERTIES OUTPUT_NAME forefeel EXPORT_NAME forefeel LINKER_LANGUAGE CXX)
target_compile_features(forefeel_library INTERFACE cxx_std_20)
target_compile_definitions(forefeel_library INTERFACE EIGEN_DONT_PARALLELIZE)
target_include_directories(forefeel_library INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_link_libraries(forefeel_library INTERFACE Eigen3::Eigen fmt::fmt SQLite::SQLite3 Threads::Threads
                      $<LINK_ONLY:OpenMP::OpenMP_CXX> tet nifti2 gmpxx mpfr gmp)
get_directory_property(FOREFEEL_HAS_ZLIB DIRECTORY ${PROJECT_SOURCE_DIR}/geometry DEFINITION ZLIB_FOUND)
get_directory_property(FOREFEEL_HAS_MPI DIRECTORY ${PROJECT_SOURCE_DIR}/scheduling DEFINITION MPI_CXX_FOUND)
if(FOREFEEL_HAS_ZLIB)
  find_package(ZLIB REQUIRED)
  target_link_libraries(forefeel_library INTERFACE ZLIB::ZLIB)
endif()
if(FOREFEEL_HAS_MPI)
  find_package(Boost REQUIRED COMPONENTS mpi)
  find_package(MPI REQUIRED COMPONENTS CXX)
  target_link_libraries(forefeel_library INTERFACE Boost::mpi MPI::MPI_CXX)
endif()

# The command as a library: the objects of apps.
set(command_objects $<TARGET_OBJECTS:forefeel_apps>)
find_package(tomlplusplus REQUIRED)
add_library(forefeel_command STATIC ${command_objects})
set_target_properties(forefeel_command PROPERTIES EXPORT_NAME command LINKER_LANGUAGE CXX)
target_link_libraries(forefeel_command INTERFACE forefeel_library $<LINK_ONLY:tomlplusplus::tomlplusplus>)

# Manual page and completion come from the command's own --help at each build, so they are never out of date.
set(manual_folder ${PROJECT_BINARY_DIR}/manual)
add_custom_command(OUTPUT ${manual_folder}/forefeel.1 ${manual_folder}/forefeel.bash
  COMMAND ${CMAKE_COMMAND} -DCOMMAND=$<TARGET_FILE:forefeel> -DVERSION=${PROJECT_VERSION} -DFOLDER=${manual_folder}
          -P ${package_folder}/manual.cmake
  DEPENDS forefeel ${package_folder}/manual.cmake COMMENT "Manual page and completion of forefeel" VERBATIM)
add_custom_target(forefeel_manual ALL DEPENDS ${manual_folder}/forefeel.1 ${manual_folder}/forefeel.bash)
# All that `cmake --install` and `cpack` need.
add_custom_target(forefeel_installable DEPENDS forefeel forefeel_library forefeel_command forefeel_manual)
if(TARGET forefeel_python)
  add_dependencies(forefeel_installable forefeel_python)
endif()

include(CMakePackageConfigHelpers)
set(config_folder ${CMAKE_INSTALL_LIBDIR}/cmake/forefeel)
configure_package_config_file(${package_folder}/forefeelConfig.cmake.in ${PROJECT_BINARY_DIR}/forefeelConfig.cmake
                              INSTALL_DESTINATION ${config_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/forefeelConfigVersion.cmake COMPATIBILITY SameMinorVersion)

install(TARGETS forefeel RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS forefeel_library EXPORT forefeel ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS forefeel_command EXPORT forefeel_command ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT forefeel NAMESPACE forefeel:: FILE forefeelTargets.cmake DESTINATION ${config_folder})
install(EXPORT forefeel_command NAMESPACE forefeel:: FILE forefeelCommandTargets.cmake DESTINATION ${config_folder})
install(FILES ${PROJECT_BINARY_DIR}/forefeelConfig.cmake ${PROJECT_BINARY_DIR}/forefeelConfigVersion.cmake
        DESTINATION ${config_folder})
install(CODE "set(SOURCE \"${PROJECT_SOURCE_DIR}\")\nset(FOLDER \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}/forefeel\")\ninclude(\"${package_folder}/install_headers.cmake\")")
if(TARGET forefeel_python)
  get_directory_property(Python_VERSION_MINOR DIRECTORY ${PROJECT_SOURCE_DIR}/apps DEFINITION Python_VERSION_MINOR)
  # Debian's Python looks into lib/python3 below /usr, and into a folder with its version below /usr/local.
  install(CODE "
    set(FOREFEEL_PYTHON_FOLDER lib/python3/dist-packages)
    if(CMAKE_INSTALL_PREFIX STREQUAL \"/usr/local\")
      set(FOREFEEL_PYTHON_FOLDER lib/python3.${Python_VERSION_MINOR}/dist-packages)
    elseif(NOT CMAKE_INSTALL_PREFIX STREQUAL \"/usr\")
      message(STATUS \"import forefeel: set PYTHONPATH=\${CMAKE_INSTALL_PREFIX}/\${FOREFEEL_PYTHON_FOLDER}\")
    endif()" COMPONENT python)
  install(TARGETS forefeel_python LIBRARY DESTINATION "\${FOREFEEL_PYTHON_FOLDER}/forefeel" COMPONENT python)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/apps/python/forefeel DESTINATION "\${FOREFEEL_PYTHON_FOLDER}" COMPONENT python
          FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi" PATTERN "py.typed" PATTERN "__pycache__" EXCLUDE)
  install(FILES ${package_folder}/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-forefeel
          COMPONENT python)
endif()
install(FILES ${manual_folder}/forefeel.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${manual_folder}/forefeel.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
        RENAME forefeel)
install(DIRECTORY apps/scenes apps/studies apps/examples apps/paper apps/peers
        DESTINATION ${CMAKE_INSTALL_DATADIR}/forefeel PATTERN "__pycache__" EXCLUDE)
# The README with the files that it links to. Its other paths are those of the source tree.
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS README.md)
file(READ README.md readme)
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/installed/README.md @ONLY CONTENT
"> Installed: `apps/scenes`, `apps/studies`, `apps/examples`, `apps/paper` and `apps/peers` are in `share/forefeel`,
> the headers in `include/forefeel`. Other scripts and tests are in the source tree alone.

@readme@")
install(FILES ${package_folder}/copyright ${PROJECT_BINARY_DIR}/installed/README.md LICENSE
        DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/forefeel)
install(DIRECTORY apps/pictures DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/forefeel/apps)
foreach(page geometry solver approx scheduling apps)
  install(FILES ${page}/README.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/forefeel/${page})
endforeach()
file(ARCHIVE_CREATE OUTPUT ${PROJECT_BINARY_DIR}/installed/changelog.Debian.gz PATHS ${package_folder}/changelog
     FORMAT raw COMPRESSION GZip)
install(FILES ${PROJECT_BINARY_DIR}/installed/changelog.Debian.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/forefeel)

# Two packages: forefeel, and python3-forefeel where the Python module is built.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME forefeel)
set(CPACK_PACKAGE_CONTACT "Forefeel developers <forefeel@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Haptic rendering of soft bodies from states solved ahead of the hand")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_COMPONENTS_ALL forefeel)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_FOREFEEL_PACKAGE_NAME forefeel)
set(CPACK_DEBIAN_FOREFEEL_PACKAGE_SECTION science)
# gnuplot draws the reports' plots; the rest is what programs built with the library need.
set(CPACK_DEBIAN_FOREFEEL_PACKAGE_RECOMMENDS "gnuplot-nox, libeigen3-dev, libfmt-dev, libsqlite3-dev, libtet1.5-dev, libnifti2-dev, libgmp-dev, libmpfr-dev, libtomlplusplus-dev, zlib1g-dev")
set(CPACK_DEBIAN_FOREFEEL_PACKAGE_SUGGESTS "g++, cmake")
set(CPACK_COMPONENT_FOREFEEL_DESCRIPTION "The command forefeel, the C++ library, scenes, studies and examples.")
if(TARGET forefeel_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  math(EXPR next_python "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-forefeel)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${next_python}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "gnuplot-nox")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-matplotlib, python3-pandas, python3-scipy")
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION "The Python package forefeel.")
endif()
set(CPACK_STRIP_FILES ON)
include(CPack)
