// Zip files, to read, by libzip: stored and deflated members of at most 1 GiB together. No member whose name leads out
// of the folder that it is unpacked to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>

struct zip;

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
    std::uint64_t index = 0;  // in the file's directory
    std::size_t length = 0;   // bytes, unpacked
  };
  // By their names, without those of folders.
  [[nodiscard]] const std::map<std::string, Member>& members() const { return members_; }
  // Unpacked, its length and checksum compared. Throws FmuError, also if there is none of this name.
  [[nodiscard]] std::string read(const std::string& name) const;

  static constexpr std::size_t kMostBytes = std::size_t{1} << 30;  // of all members, unpacked

 private:
  struct Close {
    void operator()(struct zip* archive) const;
  };
  void add_member(std::uint64_t index);

  const std::string bytes_;
  std::unique_ptr<struct zip, Close> archive_;  // reads bytes_
  std::map<std::string, Member> members_;
  std::size_t length_ = 0;  // of all members
};

}  // namespace unlatch::fmu
