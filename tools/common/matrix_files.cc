#include "tools/common/matrix_files.h"

#include <zip.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <new>
#include <utility>

namespace unlatch::tools {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

template <class T>
void append(std::string& out, T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  out.append(bytes, sizeof(T));
}
void append(std::string& out, const Eigen::MatrixXd& matrix) {
  for (Eigen::Index k = 0; k < matrix.size(); ++k) append(out, matrix.data()[k]);  // by columns
}

// Header of a matrix of MAT version 4; `type`: 0 numbers, 1 text.
void append_mat_header(std::string& out, const std::string& name, int type, Eigen::Index rows, Eigen::Index columns) {
  append<std::int32_t>(out, type);
  append(out, static_cast<std::int32_t>(rows));
  append(out, static_cast<std::int32_t>(columns));
  append<std::int32_t>(out, 0);  // no imaginary part
  append(out, static_cast<std::int32_t>(name.size() + 1));
  out.append(name.c_str(), name.size() + 1);
}

// One .npy file: `type` is NumPy's, in the order of columns if `by_columns`.
std::string build_npy(const std::string& type, const std::string& shape, bool by_columns, const std::string& data) {
  std::string header =
      "{'descr': '" + type + "', 'fortran_order': " + (by_columns ? "True" : "False") + ", 'shape': (" + shape + "), }";
  constexpr std::size_t kPreamble = 10, kMultiple = 64;
  while ((kPreamble + header.size() + 1) % kMultiple != 0) header += ' ';
  header += '\n';
  std::string out("\x93NUMPY\x01\x00", 8);
  append(out, static_cast<std::uint16_t>(header.size()));
  return out + header + data;
}

// An archive in memory of files that are stored as they are, all of the same date: the same bytes from the same
// numbers.
class StoredArchive {
 public:
  StoredArchive() : source_(zip_source_buffer_create(nullptr, 0, 0, nullptr)) {
    if (source_ == nullptr) throw std::bad_alloc();
    zip_source_keep(source_);
    archive_ = zip_open_from_source(source_, ZIP_TRUNCATE, nullptr);
    if (archive_ == nullptr) {
      zip_source_free(source_);
      throw std::bad_alloc();
    }
  }
  ~StoredArchive() {
    if (archive_ != nullptr) zip_discard(archive_);
    zip_source_free(source_);
  }
  StoredArchive(const StoredArchive&) = delete;
  StoredArchive& operator=(const StoredArchive&) = delete;

  // `data` must stay until finish().
  void add(const std::string& name, const std::string& data) {
    zip_source_t* const source = zip_source_buffer(archive_, data.data(), data.size(), 0);
    const zip_int64_t index = zip_file_add(archive_, name.c_str(), source, ZIP_FL_ENC_UTF_8);
    if (index < 0) {
      zip_source_free(source);
      throw std::bad_alloc();
    }
    constexpr zip_uint16_t kMidnight = 0, kFirstDay = 0x21;  // 1980-01-01
    zip_set_file_compression(archive_, static_cast<zip_uint64_t>(index), ZIP_CM_STORE, 0);
    zip_file_set_dostime(archive_, static_cast<zip_uint64_t>(index), kMidnight, kFirstDay, 0);
  }
  std::string finish() {
    if (zip_close(std::exchange(archive_, nullptr)) != 0 || zip_source_open(source_) != 0) throw std::bad_alloc();
    zip_source_seek(source_, 0, SEEK_END);
    std::string bytes(static_cast<std::size_t>(zip_source_tell(source_)), '\0');
    zip_source_seek(source_, 0, SEEK_SET);
    const zip_int64_t read = zip_source_read(source_, bytes.data(), bytes.size());
    zip_source_close(source_);
    if (read != std::ssize(bytes)) throw std::bad_alloc();
    return bytes;
  }

 private:
  zip_source_t* source_;
  zip_t* archive_;
};

}  // namespace

std::string build_mat(const std::vector<NamedMatrix>& matrices, const std::vector<NamedTexts>& texts) {
  std::string out;
  for (const NamedMatrix& own : matrices) {
    append_mat_header(out, own.name, 0, own.matrix.rows(), own.matrix.cols());
    append(out, own.matrix);
  }
  for (const NamedTexts& own : texts) {
    std::size_t width = 0;
    for (const std::string& text : own.texts) width = std::max(width, text.size());
    append_mat_header(out, own.name, 1, std::ssize(own.texts), static_cast<Eigen::Index>(width));
    for (std::size_t k = 0; k < width; ++k)
      for (const std::string& text : own.texts)
        append(out, static_cast<double>(k < text.size() ? static_cast<unsigned char>(text[k]) : ' '));
  }
  return out;
}

std::string build_npz(const std::vector<NamedMatrix>& matrices, const std::vector<NamedTexts>& texts) {
  std::vector<std::pair<std::string, std::string>> files;
  for (const NamedMatrix& own : matrices) {
    std::string data;
    append(data, own.matrix);
    const std::string shape = std::to_string(own.matrix.rows()) + ", " + std::to_string(own.matrix.cols());
    files.emplace_back(own.name + ".npy", build_npy("<f8", shape, true, data));
  }
  for (const NamedTexts& own : texts) {
    std::size_t width = 1;
    for (const std::string& text : own.texts) width = std::max(width, text.size());
    std::string data;
    for (const std::string& text : own.texts)
      for (std::size_t k = 0; k < width; ++k)
        append(data, static_cast<std::uint32_t>(k < text.size() ? static_cast<unsigned char>(text[k]) : 0));
    files.emplace_back(own.name + ".npy",
                       build_npy("<U" + std::to_string(width), std::to_string(own.texts.size()) + ",", false, data));
  }
  StoredArchive archive;
  for (const auto& [name, data] : files) archive.add(name, data);
  return archive.finish();
}

}  // namespace unlatch::tools
