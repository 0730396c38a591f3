# What `cmake --install build --prefix P` puts where: find_package(tremolo COMPONENTS runtime) for
# C++, libtremolo.so for C (find_package(tremolo COMPONENTS shared)), pkg-config files for both,
# and the programs. All of it may be moved afterwards. Components of `cmake --install --component`:
# development, shared, programs.
set(tremolo_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/tremolo)
set(tremolo_rooms tremolo_common tremolo_formats tremolo_runtime tremolo_c tremolo_nodal tremolo_cloth tremolo_tets
    tremolo_mixed)
# A library that is missing would be CMake's error, without a word of what to do.
set(tremolo_room_files)
foreach(room ${tremolo_rooms})
  list(APPEND tremolo_room_files "$<TARGET_FILE:${room}>")
endforeach()
install(CODE "
  foreach(file ${tremolo_room_files})
    if(NOT EXISTS \"\${file}\")
      message(FATAL_ERROR \"\${file} is not there: this build is not finished. Finish it with\\n  cmake --build ${PROJECT_BINARY_DIR}\\nor install what there is of the programs alone:\\n  cmake --install ${PROJECT_BINARY_DIR} --component programs\")
    endif()
  endforeach()" COMPONENT development)
install(TARGETS ${tremolo_rooms} EXPORT tremolo-targets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
install(EXPORT tremolo-targets NAMESPACE tremolo:: DESTINATION ${tremolo_cmake_dir}
        COMPONENT development)
foreach(room common formats runtime)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${room}/
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tremolo/${room} COMPONENT development
          FILES_MATCHING PATTERN "*.h" PATTERN "apps" EXCLUDE PATTERN "io/scenes" EXCLUDE)
endforeach()
install(FILES ${PROJECT_SOURCE_DIR}/runtime/tremolo.h ${PROJECT_SOURCE_DIR}/runtime/tremolo_cloth.h
              ${PROJECT_SOURCE_DIR}/runtime/tremolo_tets.h ${PROJECT_SOURCE_DIR}/runtime/tremolo_scene.h
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tremolo COMPONENT development)

# What this build tree can make, but was not asked to, is left out with a word.
function(tremolo_install_if_built target component)
  install(TARGETS ${target} ${ARGN} OPTIONAL COMPONENT ${component}
          RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR}
          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(CODE "
    if(NOT EXISTS \"$<TARGET_FILE:${target}>\")
      message(\"-- Left out, not built: $<TARGET_FILE_NAME:${target}> (cmake --build . --target ${target})\")
    endif()" COMPONENT ${component})
endfunction()

foreach(program tremolo tremolo-lab tremolo-view tremolo-precompute tremolo-mesh)
  if(TARGET ${program})
    tremolo_install_if_built(${program} programs)
  endif()
endforeach()

file(RELATIVE_PATH tremolo_up /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" tremolo_up "${tremolo_up}")
set(tremolo_pkgconfig tremolo)
if(TREMOLO_SHARED)
  tremolo_install_if_built(tremolo_shared shared EXPORT tremolo-shared-targets)
  install(EXPORT tremolo-shared-targets NAMESPACE tremolo:: DESTINATION ${tremolo_cmake_dir}
          COMPONENT shared)
  list(APPEND tremolo_pkgconfig tremolo-c)
endif()
foreach(package ${tremolo_pkgconfig})
  configure_file(cmake/${package}.pc.in ${PROJECT_BINARY_DIR}/${package}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${package}.pc
          DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
endforeach()

configure_package_config_file(cmake/tremolo-config.cmake.in
  ${PROJECT_BINARY_DIR}/tremolo-config.cmake
  INSTALL_DESTINATION ${tremolo_cmake_dir} PATH_VARS CMAKE_INSTALL_LIBDIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/tremolo-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/tremolo-config.cmake
              ${PROJECT_BINARY_DIR}/tremolo-config-version.cmake
        DESTINATION ${tremolo_cmake_dir} COMPONENT development)
