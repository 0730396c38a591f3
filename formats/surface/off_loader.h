// OFF for assimp, in the place of its own reader, which loses faces.
#pragma once

#include <assimp/BaseImporter.h>
#include <string>
#include <vector>

namespace tremolo {

// Gives assimp the polygons that parse_off() finds, to be cut into triangles like those of any
// other format; numbers are read as assimp reads them in an OBJ. Throws
// std::runtime_error, which assimp catches.
class OffLoader : public Assimp::BaseImporter {
 public:
  bool CanRead(const std::string& file, Assimp::IOSystem* files, bool look_inside) const override;

  // Statements of the file read last that are not taken.
  const std::vector<std::string>& notes() const { return notes_; }

 protected:
  const aiImporterDesc* GetInfo() const override;
  void InternReadFile(const std::string& file, aiScene* scene, Assimp::IOSystem* files) override;

 private:
  std::vector<std::string> notes_;
};

}  // namespace tremolo
