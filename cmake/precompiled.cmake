# Headers that most files of a target include, compiled once. Files include what they use all the
# same: a build with -DTREMOLO_PRECOMPILED_HEADERS=OFF tells what is missing.
option(TREMOLO_PRECOMPILED_HEADERS "Compile headers that many files include once a target" ON)

set(tremolo_standard_headers
  algorithm array cmath cstdint filesystem functional map memory optional span string vector)

# tremolo_precompile(TARGET HEADER...): these and the standard library's, for its C++ files.
function(tremolo_precompile target)
  if(NOT TREMOLO_PRECOMPILED_HEADERS)
    return()
  endif()
  # g++ 12 loses sight of what is a system header and warns falsely of std::string; a build without
  # precompiled headers has these warnings.
  target_compile_options(${target} PRIVATE
    $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-stringop-overflow;-Wno-stringop-overread;-Wno-array-bounds>)
  foreach(header ${tremolo_standard_headers} ${ARGN})
    target_precompile_headers(${target} PRIVATE
                              "$<$<COMPILE_LANGUAGE:CXX>:<${header}$<ANGLE-R>>")
  endforeach()
endfunction()
