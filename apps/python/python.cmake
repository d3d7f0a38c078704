# The package forefeel: a compiled module and Python files beside it, in apps/python/forefeel of the build folder.
#   PYTHONPATH=build/release/apps/python python3 -c 'import forefeel'
file(GLOB python_sources CONFIGURE_DEPENDS python/*.cpp)
file(GLOB package_files CONFIGURE_DEPENDS python/forefeel/*)
pybind11_add_module(forefeel_python MODULE NO_EXTRAS ${python_sources})
target_link_libraries(forefeel_python PRIVATE forefeel_apps forefeel_flags OpenMP::OpenMP_CXX)
set(package_build_folder ${CMAKE_CURRENT_BINARY_DIR}/python/forefeel)
set_target_properties(forefeel_python PROPERTIES OUTPUT_NAME _core LIBRARY_OUTPUT_DIRECTORY ${package_build_folder}
                      CXX_VISIBILITY_PRESET hidden)
foreach(file IN LISTS package_files)
  get_filename_component(name ${file} NAME)
  add_custom_command(OUTPUT ${package_build_folder}/${name} COMMAND ${CMAKE_COMMAND} -E copy ${file} ${package_build_folder}
                     DEPENDS ${file} COMMENT "")
  list(APPEND package_copies ${package_build_folder}/${name})
endforeach()
add_custom_target(forefeel_python_files DEPENDS ${package_copies})
add_dependencies(forefeel_python forefeel_python_files)
