// PETSc is started once for all tests.
#include <gtest/gtest.h>

#include "precompute/system/petsc.h"

int main(int count, char** words) {
  ::testing::InitGoogleTest(&count, words);
  const tremolo::PetscSession session(words[0], {});
  return RUN_ALL_TESTS();
}
