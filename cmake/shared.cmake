# libtremolo.so: the whole engine behind the C interface, tremolo.h, tremolo_cloth.h, tremolo_tets.h
# and tremolo_scene.h. It exports the functions of these headers and nothing else: C++ across a library's
# boundary would bind both sides to one compiler, one set of flags and one Eigen. C++ programs take the
# static libraries.
include(CheckLinkerFlag)
set(tremolo_abi ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
add_library(tremolo_shared SHARED ${PROJECT_SOURCE_DIR}/cmake/shared.c)
add_library(tremolo::shared ALIAS tremolo_shared)
set_target_properties(tremolo_shared PROPERTIES
  EXPORT_NAME shared OUTPUT_NAME tremolo LINKER_LANGUAGE CXX
  VERSION ${PROJECT_VERSION} SOVERSION ${tremolo_abi}
  LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)
# All that have functions of the headers, once each, though one comes by the others too. Scene files
# are read by archives of their own, which the engine does not know.
set(tremolo_whole)
foreach(archive c cloth tets mixed scene_c)
  list(APPEND tremolo_whole $<TARGET_FILE:tremolo_${archive}>)
endforeach()
set(tremolo_readers)
if(TREMOLO_BUILD_PROGRAM)
  set(tremolo_readers $<TARGET_FILE:tremolo_nodal_reader> $<TARGET_FILE:tremolo_scene_reader>)
endif()
target_link_libraries(tremolo_shared PRIVATE
  $<BUILD_INTERFACE:-Wl,--whole-archive> "$<BUILD_INTERFACE:${tremolo_whole}>"
  $<BUILD_INTERFACE:-Wl,--no-whole-archive> "$<BUILD_INTERFACE:${tremolo_readers}>"
  $<BUILD_INTERFACE:$<TARGET_FILE:tremolo_nodal>>
  $<BUILD_INTERFACE:$<TARGET_FILE:tremolo_runtime>>
  $<BUILD_INTERFACE:tremolo_formats> $<BUILD_INTERFACE:tremolo_common>
  $<BUILD_INTERFACE:Threads::Threads> $<BUILD_INTERFACE:tremolo_flags>)
add_dependencies(tremolo_shared tremolo_c tremolo_runtime tremolo_cloth tremolo_tets tremolo_nodal
                 tremolo_mixed tremolo_scene_c)
set_property(TARGET tremolo_shared PROPERTY LINK_DEPENDS
  "${tremolo_whole};${tremolo_readers};$<TARGET_FILE:tremolo_nodal>;$<TARGET_FILE:tremolo_runtime>")
target_include_directories(tremolo_shared INTERFACE
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/runtime> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
set(tremolo_map ${PROJECT_BINARY_DIR}/tremolo.map)
file(WRITE ${tremolo_map}.new "TREMOLO_${tremolo_abi} { global: tremolo_*; local: *; };\n")
file(COPY_FILE ${tremolo_map}.new ${tremolo_map} ONLY_IF_DIFFERENT)
check_linker_flag(CXX -Wl,--version-script=${tremolo_map} TREMOLO_HAS_VERSION_SCRIPT)
if(TREMOLO_HAS_VERSION_SCRIPT)
  target_link_options(tremolo_shared PRIVATE -Wl,--version-script=${tremolo_map})
  set_property(TARGET tremolo_shared APPEND PROPERTY LINK_DEPENDS ${tremolo_map})
endif()
