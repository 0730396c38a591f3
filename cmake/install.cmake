# find_package(tremolo COMPONENTS runtime): the engine and what it stands on.
set(tremolo_rooms tremolo_common tremolo_formats tremolo_runtime)
install(TARGETS ${tremolo_rooms} EXPORT tremolo-targets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT tremolo-targets NAMESPACE tremolo::
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/tremolo)
foreach(room common formats runtime)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${room}/
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tremolo/${room}
          FILES_MATCHING PATTERN "*.h" PATTERN "program" EXCLUDE)
endforeach()
install(FILES ${PROJECT_SOURCE_DIR}/runtime/tremolo.h
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tremolo)

configure_package_config_file(cmake/tremolo-config.cmake.in
  ${PROJECT_BINARY_DIR}/tremolo-config.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/tremolo)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/tremolo-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/tremolo-config.cmake
              ${PROJECT_BINARY_DIR}/tremolo-config-version.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/tremolo)

foreach(program tremolo tremolo-precompute tremolo-mesh)
  if(TARGET ${program})
    install(TARGETS ${program} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  endif()
endforeach()
