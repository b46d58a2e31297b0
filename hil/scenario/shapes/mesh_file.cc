#include "hil/scenario/shapes/mesh_file.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <optional>

#include "hil/scenario/text/base64.h"
#include "hil/scenario/text/count.h"
#include "hil/scenario/text/utf8.h"

namespace unlatch::hil {
namespace {

using Corner = std::array<float, 3>;

bool is_finite(const Corner& p) { return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]); }

// Returns false for a triangle without area: its corners lie on a line, to rounding.
bool has_area(const Corner& a, const Corner& b, const Corner& c) {
  constexpr double kThin = 1e-7;  // relative to its longest side: the rounding of single precision
  const auto between = [](const Corner& p, const Corner& q) {
    return Vec3{static_cast<double>(q[0]), static_cast<double>(q[1]), static_cast<double>(q[2])} -
           Vec3{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
  };
  const Vec3 u = between(a, b), v = between(a, c), w = between(b, c);
  const double longest = std::max({norm(u), norm(v), norm(w)});
  return norm(cross(u, v)) > kThin * longest * longest;
}

// --- Triangles as they are found ------------------------------------------------------------------------------------

class Builder {
 public:
  // Number of a corner, which is added if it is new. Throws if there are too many.
  std::uint16_t add_vertex(Corner p) {
    for (float& x : p) x += 0.0F;  // −0 and 0 are the same place
    const std::array<std::uint32_t, 3> key = std::bit_cast<std::array<std::uint32_t, 3>>(p);
    const auto [at, is_new] = numbers_.try_emplace(key, static_cast<std::uint16_t>(mesh_.vertices.size()));
    if (!is_new) return at->second;
    if (mesh_.vertices.size() == kMaxMeshVertices)
      throw MeshError("it has more than " + std::to_string(kMaxMeshVertices) +
                      " corners: reduce it where it was made; a clearance needs no finer one");
    mesh_.vertices.push_back(p);
    return at->second;
  }

  void add_triangle(const Corner& a, const Corner& b, const Corner& c) {
    if (!has_area(a, b, c)) return;
    if (mesh_.triangles.size() == kMaxMeshTriangles)
      throw MeshError("it has more than " + std::to_string(kMaxMeshTriangles) +
                      " triangles: reduce it where it was made; a clearance needs no finer one");
    const std::uint16_t i = add_vertex(a), k = add_vertex(b);
    mesh_.triangles.push_back({i, k, add_vertex(c)});
  }

  MeshData finish() {
    if (mesh_.triangles.empty()) throw MeshError("it has no triangle with an area");
    return std::move(mesh_);
  }

 private:
  MeshData mesh_;
  std::map<std::array<std::uint32_t, 3>, std::uint16_t> numbers_;  // vertex numbers, by the bits of the corners
};

// --- Words of a text ------------------------------------------------------------------------------------------------

// Words of a text, in lower case where they are keywords; lines are counted from 1.
class Words {
 public:
  explicit Words(std::string_view text) : rest_(text) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw MeshError("line " + std::to_string(line_) + ": " + what);
  }
  // Moves to the next line that is not empty; false at the end.
  bool next_line() {
    do {
      if (rest_.empty()) return false;
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      own_ = rest_.substr(0, end);
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      ++line_;
    } while (is_at_end_of_line());
    return true;
  }
  bool is_at_end_of_line() {
    own_.remove_prefix(std::min(own_.find_first_not_of(kBlank), own_.size()));
    return own_.empty();
  }
  // Next word; empty at the end of the line.
  std::string_view next() {
    is_at_end_of_line();
    const std::string_view word = own_.substr(0, std::min(own_.find_first_of(kBlank), own_.size()));
    own_.remove_prefix(word.size());
    return word;
  }
  std::string next_keyword() {
    std::string word(next().substr(0, 40));
    for (char& c : word) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    return word;
  }
  // Next word of the file, whatever its line; for formats that do not depend on lines.
  std::string next_keyword_of_any_line() {
    while (is_at_end_of_line())
      if (!next_line()) return "";
    return next_keyword();
  }
  void skip_line() { own_ = {}; }

  float next_number() {
    std::string_view word = next();
    const std::string_view whole = word;
    if (word.starts_with('+')) word.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (whole.empty()) fail("a number is missing");
    if (error != std::errc() || end != word.data() + word.size()) fail(quote_text(whole) + " is not a number");
    const auto number = static_cast<float>(value);
    if (!std::isfinite(number)) fail(quote_text(whole) + " is not finite in single precision");
    return number;
  }
  Corner next_corner() {
    const float x = next_number(), y = next_number();
    return {x, y, next_number()};
  }

 private:
  static constexpr std::string_view kBlank = " \t\r\v\f";
  std::string_view rest_, own_;
  int line_ = 0;
};

// --- STL ------------------------------------------------------------------------------------------------------------

constexpr std::size_t kHeader = 84, kFacet = 50;  // bytes: header with the count; one triangle

std::uint32_t read_word(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = 4; i-- > 0;) word = word << 8 | static_cast<std::uint8_t>(bytes[at + i]);
  return word;
}

Corner read_corner(std::string_view bytes, std::size_t at) {
  Corner p;
  for (std::size_t i = 0; i < 3; ++i) p[i] = std::bit_cast<float>(read_word(bytes, at + 4 * i));
  return p;
}

MeshData read_binary_stl(std::string_view bytes) {
  Builder builder;
  for (std::size_t at = kHeader; at < bytes.size(); at += kFacet) {
    Corner corners[3];
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = read_corner(bytes, at + 12 * (k + 1));
      if (!is_finite(corners[k]))
        throw MeshError("triangle " + std::to_string((at - kHeader) / kFacet + 1) + ": a coordinate is not finite");
    }
    builder.add_triangle(corners[0], corners[1], corners[2]);
  }
  return builder.finish();
}

MeshData read_ascii_stl(std::string_view text) {
  Builder builder;
  Words words(text);
  const auto expect = [&](const char* word) {
    const std::string found = words.next_keyword_of_any_line();
    if (found != word) words.fail(quote_text(found) + " where '" + word + "' belongs");
  };
  expect("solid");
  words.skip_line();
  for (;;) {
    const std::string word = words.next_keyword_of_any_line();
    if (word == "endsolid") {
      words.skip_line();
      if (!words.next_line()) return builder.finish();
      expect("solid");
      words.skip_line();
      continue;
    }
    if (word.empty()) words.fail("it ends within a solid: the rest is missing");
    if (word != "facet") words.fail(quote_text(word) + " where 'facet' or 'endsolid' belongs");
    expect("normal");
    words.skip_line();
    expect("outer");
    expect("loop");
    Corner corners[3];
    for (Corner& corner : corners) {
      expect("vertex");
      corner = words.next_corner();
    }
    expect("endloop");
    expect("endfacet");
    builder.add_triangle(corners[0], corners[1], corners[2]);
  }
}

MeshData read_stl(std::string_view bytes) {
  if (bytes.size() >= kHeader) {
    const std::uint64_t count = read_word(bytes, kHeader - 4), whole = kHeader + kFacet * count;
    if (whole == bytes.size()) return read_binary_stl(bytes);
    if (Words words(bytes); !words.next_line() || words.next_keyword() != "solid")
      throw MeshError("it has " + hil::count(bytes.size(), "byte") + ", and its " + hil::count(count, "triangle") +
                      " would take " + std::to_string(whole) + ": it is cut short, or no STL file");
  }
  return read_ascii_stl(bytes);
}

// --- OBJ ------------------------------------------------------------------------------------------------------------

class ObjReader {
 public:
  explicit ObjReader(std::string_view text) : words_(text) {}

  MeshData read() {
    while (words_.next_line()) {
      const std::string word = words_.next_keyword();
      if (word == "v")
        add_corner(words_.next_corner());  // a weight or colours may follow
      else if (word == "f")
        read_face();
      else if (word[0] != '#' && std::find(std::begin(kIgnored), std::end(kIgnored), word) == std::end(kIgnored))
        words_.fail(quote_text(word) + " is no keyword of OBJ");
      words_.skip_line();
    }
    return builder_.finish();
  }

 private:
  static constexpr std::string_view kIgnored[] = {"vt", "vn", "vp", "o", "g", "s", "usemtl", "mtllib", "l", "p"};

  void add_corner(const Corner& corner) {
    constexpr std::size_t kMost = 1'000'000;  // triangles may use at most kMaxMeshVertices of them
    if (corners_.size() == kMost) words_.fail("more than 1000000 corners");
    corners_.push_back(corner);
  }

  void read_face() {
    std::optional<Corner> first, before;
    int count = 0;
    for (; !words_.is_at_end_of_line(); ++count) {
      const Corner corner = find_corner(words_.next());
      if (!first)
        first = corner;
      else if (before)
        builder_.add_triangle(*first, *before, corner);
      if (count > 0) before = corner;
    }
    if (count < 3) words_.fail("a face of " + hil::count(count, "corner"));
  }

  // Finds a corner: "7", "7/1", "7//3", "-1/2/3": the first number counts corners from 1, or back from the latest one.
  Corner find_corner(std::string_view word) {
    const std::string_view own = word.substr(0, word.find('/'));
    const auto count = static_cast<std::int64_t>(corners_.size());
    std::int64_t number = 0;
    const auto [end, error] = std::from_chars(own.data(), own.data() + own.size(), number);
    if (error != std::errc() || end != own.data() + own.size())
      words_.fail(quote_text(word) + " is no corner of a face");
    const std::int64_t index = number < 0 ? count + number : number - 1;
    if (index < 0 || index >= count)
      words_.fail("corner " + std::to_string(number) + " of " + std::to_string(count) + " that are known by here");
    return corners_[static_cast<std::size_t>(index)];
  }

  Words words_;
  Builder builder_;
  std::vector<Corner> corners_;
};

bool ends_in(const std::string& name, std::string_view ending) {
  return name.size() > ending.size() &&
         std::equal(ending.begin(), ending.end(), name.end() - static_cast<std::ptrdiff_t>(ending.size()),
                    [](char wanted, char c) { return wanted == (c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
}

}  // namespace

MeshData read_mesh(std::string_view bytes, const std::string& name) {
  if (bytes.size() > kMaxMeshFile) throw MeshError("it has more than " + std::to_string(kMaxMeshFile >> 20) + " MiB");
  if (ends_in(name, ".stl")) return read_stl(bytes);
  if (ends_in(name, ".obj")) return ObjReader(bytes).read();
  throw MeshError("its name ends neither in .stl nor in .obj");
}

// --- The text of recordings -----------------------------------------------------------------------------------------

namespace {

const std::string kMeshTextBegin = "unlatch-mesh 1\n";
constexpr std::size_t kVertexBytes = 12, kTriangleBytes = 6;

void append(std::uint32_t word, std::size_t count, std::vector<std::uint8_t>& bytes) {
  for (std::size_t i = 0; i < count; ++i) bytes.push_back(static_cast<std::uint8_t>(word >> 8 * i & 255));
}

}  // namespace

std::string write_mesh_text(const MeshData& mesh) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(kVertexBytes * mesh.vertices.size() + kTriangleBytes * mesh.triangles.size());
  for (const Corner& p : mesh.vertices)
    for (const float x : p) append(std::bit_cast<std::uint32_t>(x), 4, bytes);
  for (const auto& triangle : mesh.triangles)
    for (const std::uint16_t i : triangle) append(i, 2, bytes);
  return kMeshTextBegin + std::to_string(mesh.vertices.size()) + " " + std::to_string(mesh.triangles.size()) + "\n" +
         to_base64(bytes) + "\n";
}

bool is_mesh_text(std::string_view text) { return text.starts_with(kMeshTextBegin); }

MeshData read_mesh_text(std::string_view text) {
  const auto fail = [] { throw MeshError("this is not a mesh as recordings hold it"); };
  Words words(text.substr(std::min(kMeshTextBegin.size(), text.size())));
  const auto read_count = [&](std::size_t most) {
    const std::string_view word = words.next();
    std::size_t count = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), count);
    if (error != std::errc() || end != word.data() + word.size() || count == 0 || count > most) fail();
    return count;
  };
  if (!is_mesh_text(text) || !words.next_line()) fail();
  const std::size_t vertices = read_count(kMaxMeshVertices), triangles = read_count(kMaxMeshTriangles);
  if (!words.is_at_end_of_line() || !words.next_line()) fail();
  const auto bytes = from_base64(words.next());
  if (!bytes || bytes->size() != kVertexBytes * vertices + kTriangleBytes * triangles || !words.is_at_end_of_line())
    fail();
  const std::string_view view(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  MeshData mesh;
  for (std::size_t i = 0; i < vertices; ++i) {
    mesh.vertices.push_back(read_corner(view, kVertexBytes * i));
    if (!is_finite(mesh.vertices.back())) fail();
  }
  for (std::size_t at = kVertexBytes * vertices; at < view.size(); at += kTriangleBytes) {
    std::array<std::uint16_t, 3>& triangle = mesh.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const unsigned low = (*bytes)[at + 2 * k], high = (*bytes)[at + 2 * k + 1];
      triangle[k] = static_cast<std::uint16_t>(high << 8 | low);
      if (triangle[k] >= vertices) fail();
    }
    if (!has_area(mesh.vertices[triangle[0]], mesh.vertices[triangle[1]], mesh.vertices[triangle[2]])) fail();
  }
  return mesh;
}

}  // namespace unlatch::hil
