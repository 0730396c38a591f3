# Headers that most files of a target include, compiled once. Files include what they use all the
# same: a build with -DTREMOLO_PRECOMPILED_HEADERS=OFF tells what is missing.
option(TREMOLO_PRECOMPILED_HEADERS "Compile headers that many files include once a target" ON)

set(tremolo_standard_headers
  algorithm array cmath cstdint filesystem functional map memory optional span string vector)

# g++ 12 loses sight of what is a system header and warns falsely of std::string; a build without
# precompiled headers has these warnings.
set(tremolo_precompiled_flags
  $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-stringop-overflow;-Wno-stringop-overread;-Wno-array-bounds>)

# tremolo_precompile(TARGET HEADER...): these and the standard library's, for its C++ files.
function(tremolo_precompile target)
  if(NOT TREMOLO_PRECOMPILED_HEADERS)
    return()
  endif()
  target_compile_options(${target} PRIVATE ${tremolo_precompiled_flags})
  foreach(header ${tremolo_standard_headers} ${ARGN})
    target_precompile_headers(${target} PRIVATE
                              "$<$<COMPILE_LANGUAGE:CXX>:<${header}$<ANGLE-R>>")
  endforeach()
endfunction()

# tremolo_precompile_as(TARGET ORIGIN): those of another target that is compiled alike.
function(tremolo_precompile_as target origin)
  if(TREMOLO_PRECOMPILED_HEADERS)
    target_compile_options(${target} PRIVATE ${tremolo_precompiled_flags})
    target_precompile_headers(${target} REUSE_FROM ${origin})
  endif()
endfunction()
