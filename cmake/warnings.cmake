# Flags of the project's own code. They stay inside it: a consumer gets none of them.
add_library(tremolo_flags INTERFACE)
target_compile_options(tremolo_flags INTERFACE
  -Wall -Wextra -Wconversion -Wno-sign-conversion -Wshadow -Wpedantic
  $<$<COMPILE_LANGUAGE:CXX>:-Wnon-virtual-dtor>
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)  # g++ 12 warns falsely on every "literal" + std::string
# Honour `#pragma omp simd` (reductions vectorise without -ffast-math); no OpenMP runtime is linked.
target_compile_options(tremolo_flags INTERFACE -fopenmp-simd)
# tremolo_light(TARGET): code whose time does not count, which is compiled the faster for it.
function(tremolo_light target)
  if(EMSCRIPTEN)
    return()
  endif()
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()
if(TREMOLO_SANITIZE)
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=undefined
                      -fno-omit-frame-pointer)
  if(NOT TREMOLO_SANITIZE_ALL)
    # These are a third of the time to compile; the first shows as a fault anyway.
    add_compile_options(-fno-sanitize=null,alignment,vptr,object-size)
  endif()
  add_link_options(-fsanitize=address,undefined)
  add_compile_definitions(TREMOLO_SANITIZED=1)
endif()
if(TREMOLO_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined
                      -fno-omit-frame-pointer -gline-tables-only -O1)
  add_link_options(-fsanitize=address,undefined)
  add_compile_definitions(TREMOLO_SANITIZED=1 TREMOLO_FUZZING=1 _GLIBCXX_ASSERTIONS=1)
endif()

# g++ tidies its memory again and again unless it may fill a gigabyte: an eighth of the compile time, for 0.2 GB
# more at its peak.
target_compile_options(tremolo_flags INTERFACE
  $<$<COMPILE_LANG_AND_ID:CXX,GNU>:--param=ggc-min-heapsize=1048576>)
