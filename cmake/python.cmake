# The Python module, if it can be built: it reads scenes, and needs pybind11 and Python's headers.
if(TREMOLO_FUZZ OR EMSCRIPTEN OR NOT TREMOLO_BUILD_PROGRAM OR NOT TREMOLO_BUILD_PYTHON)
  return()
endif()
set(Python3_EXECUTABLE ${TREMOLO_PYTHON})
find_package(Python3 QUIET COMPONENTS Interpreter Development.Module)
# pybind11 takes the interpreter by this name.
set(PYTHON_EXECUTABLE ${TREMOLO_PYTHON})
find_package(pybind11 2.10 QUIET CONFIG)
if(NOT Python3_FOUND OR NOT pybind11_FOUND)
  message(STATUS "The Python module is left out: it needs ${TREMOLO_PYTHON}, python3-dev and pybind11-dev")
  return()
endif()
add_subdirectory(${PROJECT_SOURCE_DIR}/runtime/apps/python ${PROJECT_BINARY_DIR}/runtime/apps/python)
