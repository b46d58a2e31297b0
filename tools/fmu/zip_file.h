// Zip files (PKWARE's APPNOTE, 4.3), to read: stored and deflated members, with bounds on everything that the file
// states. No member whose name leads out of the folder that it is unpacked to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>

namespace unlatch::fmu {

// A mistake of an FMU, in a sentence that begins with the place in it.
class FmuError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class ZipFile {
 public:
  // `bytes`: the whole file. Throws FmuError.
  explicit ZipFile(std::string bytes);

  struct Member {
    std::size_t offset = 0;              // of its local header
    std::size_t packed = 0, length = 0;  // bytes in the file, and unpacked
    std::uint32_t crc = 0;
    bool deflated = false;
  };
  // By their names, without those of folders.
  [[nodiscard]] const std::map<std::string, Member>& members() const { return members_; }
  // Unpacked. Throws FmuError, also if there is none of this name.
  [[nodiscard]] std::string read(const std::string& name) const;

  static constexpr std::size_t kMostBytes = std::size_t{1} << 30;  // of all members, unpacked

 private:
  void add_member(std::size_t at, std::size_t& length);
  [[nodiscard]] std::uint64_t get(std::size_t at, int bytes) const;

  const std::string bytes_;
  std::map<std::string, Member> members_;
};

}  // namespace unlatch::fmu
