#include "tools/fmu/zip_file.h"

#include <zip.h>

#include <algorithm>
#include <utility>

namespace unlatch::fmu {
namespace {

// A relative path that stays inside: no "..", no drive.
bool is_inside(const std::string& name) {
  if (name.empty() || name.front() == '/' || name.find_first_of(std::string(":\0", 2)) != std::string::npos)
    return false;
  for (std::size_t begin = 0; begin <= name.size();) {
    const std::size_t end = std::min(name.find('/', begin), name.size());
    if (name.compare(begin, end - begin, "..") == 0) return false;
    begin = end + 1;
  }
  return true;
}

}  // namespace

void ZipFile::Close::operator()(struct zip* archive) const { zip_discard(archive); }

ZipFile::ZipFile(std::string bytes) : bytes_(std::move(bytes)) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* const source = zip_source_buffer_create(bytes_.data(), bytes_.size(), 0, &error);
  if (source != nullptr) {
    archive_.reset(zip_open_from_source(source, ZIP_RDONLY, &error));
    if (!archive_) zip_source_free(source);
  }
  const std::string reason = archive_ ? "" : zip_error_strerror(&error);
  zip_error_fini(&error);
  if (!archive_) throw FmuError("it is no zip file, or not whole (" + reason + ")");
  const zip_int64_t count = zip_get_num_entries(archive_.get(), 0);
  for (zip_int64_t i = 0; i < count; ++i) add_member(static_cast<std::uint64_t>(i));
}

void ZipFile::add_member(std::uint64_t index) {
  constexpr zip_uint64_t kNeeded = ZIP_STAT_NAME | ZIP_STAT_SIZE | ZIP_STAT_COMP_METHOD | ZIP_STAT_ENCRYPTION_METHOD;
  zip_stat_t stat;
  if (zip_stat_index(archive_.get(), index, ZIP_FL_ENC_RAW, &stat) != 0 || (stat.valid & kNeeded) != kNeeded)
    throw FmuError("its directory is damaged");
  std::string name = stat.name;
  std::replace(name.begin(), name.end(), '\\', '/');  // some programs on Windows write them, against the standard
  if (!is_inside(name)) throw FmuError("a member is called '" + name + "', which leads out of the FMU's folder");
  if (name.back() == '/') return;
  if (stat.encryption_method != ZIP_EM_NONE) throw FmuError(name + ": it is encrypted");
  if (stat.comp_method != ZIP_CM_STORE && stat.comp_method != ZIP_CM_DEFLATE)
    throw FmuError(name + ": compressed by method " + std::to_string(stat.comp_method) +
                   "; 0 and 8 (deflate) can be read");
  if (stat.size > kMostBytes - length_) throw FmuError("unpacked it would be larger than 1 GiB");
  length_ += stat.size;
  if (!members_.emplace(name, Member{index, stat.size}).second) throw FmuError(name + ": it is there twice");
}

std::string ZipFile::read(const std::string& name) const {
  const auto found = members_.find(name);
  if (found == members_.end()) throw FmuError(name + ": it is not in the zip file");
  const Member& member = found->second;
  const std::unique_ptr<zip_file_t, decltype(&zip_fclose)> file(zip_fopen_index(archive_.get(), member.index, 0),
                                                                &zip_fclose);
  if (!file) throw FmuError(name + ": it cannot be unpacked (" + zip_strerror(archive_.get()) + ")");
  std::string made(member.length + 1, '\0');  // one byte more: that the member ends
  std::size_t count = 0;
  for (zip_int64_t part = 1; part > 0 && count < made.size(); count += static_cast<std::size_t>(part)) {
    part = zip_fread(file.get(), made.data() + count,
                     made.size() - count);  // the read that finds the end compares the checksum
    if (part < 0) throw FmuError(name + ": it is damaged (" + zip_file_strerror(file.get()) + ")");
  }
  if (count != member.length) throw FmuError(name + ": it is not as long as the zip file states");
  made.resize(member.length);
  return made;
}

}  // namespace unlatch::fmu
