#include "geometry/segmentation/raw_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>

#ifdef FOREFEEL_ZLIB
#include <zlib.h>
#endif

#include "geometry/common/error.hpp"
#include "geometry/common/memory.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/mesh/length_unit.hpp"

namespace forefeel {
namespace {

constexpr std::size_t most_labels = 65'535;

void check_axes(const ImageHeader& header, const std::string& file) {
  const double volume = std::abs(header.axes.determinant());
  const double steps = header.axes.col(0).norm() * header.axes.col(1).norm() * header.axes.col(2).norm();
  if (!header.axes.allFinite() || !header.origin.allFinite() || !(volume > 1e-6 * steps) ||
      !(volume > 1e-30) || !(volume < 1e30))
    throw InputError({.file = file},
                     "its spacing and orientation give voxels without a volume, expected three "
                     "independent axes of positive length");
}

}  // namespace

void name_unit(ImageHeader& header, std::string_view word) {
  if (const std::optional<double> metres = unit_of(word)) {
    header.unit = *metres;
    header.unit_name = unit_name(*metres);
    header.unit_given = true;
  } else {
    header.unit_unknown = word;
  }
}

double positive_size(double size, const std::string& entry, std::vector<std::string>& warnings) {
  if (size < 0) warnings.push_back(fmt::format("{} is {:g}, taken as {:g}", entry, size, -size));
  return std::abs(size);
}

std::size_t checked_voxels(const ImageHeader& header, const std::string& file, std::size_t bytes_each) {
  double voxels = 1;
  for (const std::int64_t n : header.size) {
    if (n < 1)
      throw InputError({.file = file}, fmt::format("{} x {} x {} voxels, expected three positive sizes",
                                                   header.size[0], header.size[1], header.size[2]));
    voxels *= static_cast<double>(n);
  }
  const double needed = voxels * static_cast<double>(bytes_each + sizeof(std::uint16_t)),
               left = available_memory();
  if (!(voxels < 1e15) || needed > left)
    throw InputError({.file = file}, fmt::format("{} x {} x {} voxels need {} of memory, {} are left",
                                                 header.size[0], header.size[1], header.size[2],
                                                 bytes_in_words(needed), bytes_in_words(left)));
  return static_cast<std::size_t>(voxels);
}

LabelCollector::LabelCollector(const ImageHeader& header, std::size_t voxels, const std::string& file)
    : header_(header), file_(file) {
  check_axes(header, file);
  volume_.size = header.size;
  volume_.axes = header.unit * header.axes;
  volume_.origin = header.unit * header.origin;
  volume_.unit = header.unit_name;
  volume_.metres = header.unit;
  volume_.unit_given = header.unit_given;
  volume_.unit_unknown = header.unit_unknown;
  volume_.directions = header.directions;
  volume_.warnings = header.warnings;
  volume_.voxels.resize(voxels);
}

void LabelCollector::put(std::size_t at, double stored) {
  const double value = header_.slope * stored + header_.intercept;
  if (!(std::abs(value) < 1e15) || value != std::floor(value))
    throw InputError({.file = file_},
                     fmt::format("voxel {} (from 0) is {:g}, expected labels, whole numbers", at, value));
  const auto label = static_cast<std::int64_t>(value);
  if (found_.empty() || label != last_) last_position_ = position_of(label), last_ = label;
  volume_.voxels[at] = last_position_;
}

std::uint16_t LabelCollector::position_of(std::int64_t label) {
  const auto [at, is_new] = position_.emplace(label, static_cast<std::uint16_t>(found_.size()));
  if (is_new) {
    if (found_.size() == most_labels)
      throw InputError({.file = file_},
                       fmt::format("more than {} different values, expected a volume of labels, not "
                                   "a scan",
                                   most_labels));
    found_.push_back(label);
  }
  return at->second;
}

LabelVolume LabelCollector::take() {
  std::vector<std::size_t> order(found_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t k) { return found_[k]; });
  std::vector<std::uint16_t> position(found_.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    position[order[k]] = static_cast<std::uint16_t>(k);
    volume_.values.push_back(found_[order[k]]);
  }
  for (std::uint16_t& voxel : volume_.voxels) voxel = position[voxel];
  return std::move(volume_);
}

LabelVolume labels_of(const ImageHeader& header, std::string_view data, const std::string& file) {
  LabelCollector to(header, data.size() / bytes_of(header.type), file);
  with_type(header.type, [&]<class T>(T value) {
    for (std::size_t v = 0; (v + 1) * sizeof(T) <= data.size(); ++v) {
      std::memcpy(&value, data.data() + v * sizeof(T), sizeof(T));
      to.put(v, static_cast<double>(header.swap ? byte_swapped(value) : value));
    }
  });
  return to.take();
}

LabelVolume labels_in(const ImageHeader& header, std::string_view content, bool compressed,
                      const std::string& file) {
  const std::size_t each = bytes_of(header.type);
  const std::size_t bytes = each * checked_voxels(header, file, compressed ? each : 0);
  // Deflate packs at most 1032 bytes into one.
  const bool fits = compressed ? bytes / 1032 <= content.size() : bytes <= content.size();
  const std::string plain = compressed && fits ? inflate(content, bytes, file) : std::string();
  const std::string_view data = compressed ? std::string_view(plain) : content;
  if (!fits || data.size() < bytes)
    throw InputError(
        {.file = file},
        fmt::format("{} x {} x {} voxels need {} bytes, and the data are shorter; the file is cut short",
                    header.size[0], header.size[1], header.size[2], bytes));
  LabelVolume volume = labels_of(header, data.substr(0, bytes), file);
  if (data.size() > bytes)
    volume.warnings.push_back(
        fmt::format("{} bytes behind the last voxel are left out", data.size() - bytes));
  return volume;
}

LabelVolume labels_in_text(const ImageHeader& header, std::string_view text, const std::string& file) {
  const std::size_t voxels = checked_voxels(header, file, 0);
  if (voxels > text.size())
    throw InputError({.file = file}, "the text holds fewer numbers than voxels, the file is cut short");
  Scanner in(std::string(text), file);
  LabelCollector to(header, voxels, file);
  for (std::size_t v = 0; v < voxels; ++v) to.put(v, in.real("the label of a voxel"));
  return to.take();
}

std::string HeaderFields::get(const std::string& key) const {
  const auto found = values.find(key);
  return found == values.end() ? std::string() : found->second;
}

std::vector<double> HeaderFields::numbers(const std::string& key, std::size_t expected) const {
  std::string text = get(key);
  for (char& letter : text)
    if (letter == '(' || letter == ')' || letter == ',') letter = ' ';
  Scanner in(text, file + ": " + key);
  std::vector<double> numbers;
  while (!in.at_end()) numbers.push_back(in.real("a number"));
  if (numbers.size() != expected)
    fail(fmt::format("{} has {} numbers, expected {}", key, numbers.size(), expected));
  return numbers;
}

std::array<std::int64_t, 3> HeaderFields::voxels(const std::string& key) const {
  const std::vector<double> given = numbers(key, 3);
  std::array<std::int64_t, 3> size{};
  for (std::size_t d = 0; d < 3; ++d) {
    if (!(std::abs(given[d]) < 1e15) || given[d] != std::floor(given[d]))
      fail(fmt::format("{} {:g} is no number of voxels", key, given[d]));
    size[d] = static_cast<std::int64_t>(given[d]);
  }
  return size;
}

Scalar HeaderFields::type(const std::string& key, const std::string& word, const TypeNames& names) const {
  for (const auto& [type, words] : names)
    if (!word.empty() && ("," + std::string(words) + ",").find("," + word + ",") != std::string::npos)
      return type;
  fail(fmt::format("{} '{:.40}' is not read, expected {}, {} and the like", key, word,
                   names[1].second.substr(0, names[1].second.find(',')),
                   names[2].second.substr(0, names[2].second.find(','))));
}

std::string read_beside(const std::filesystem::path& header, const std::string& name) {
  const std::filesystem::path file = name.starts_with("./") ? name.substr(2) : name;
  if (name.empty() || file.has_parent_path() || file == "..")
    throw InputError({.file = header.string()},
                     fmt::format("names its data '{:.60}', expected a file in the same folder", name));
  return read_file(header.parent_path() / file);
}

bool is_label_volume_file(const std::filesystem::path& file) {
  const std::string name = lower_case(file.filename().string());
  return std::ranges::any_of(std::array{".nii", ".nii.gz", ".mha", ".mhd", ".nrrd", ".nhdr", ".vti"},
                             [&](const char* extension) { return name.ends_with(extension); });
}

LabelVolume read_label_volume(const std::filesystem::path& file) {
  const std::string name = lower_case(file.filename().string());
  if (!is_label_volume_file(file))
    throw InputError({.file = file.string()},
                     fmt::format("unknown kind of label volume, expected {}", label_volume_extensions));
  std::string content = read_file(file);
  if (name.ends_with(".vti")) return read_vti(std::move(content), file.string());
  if (name.ends_with(".mha") || name.ends_with(".mhd")) return read_meta_image(content, file);
  if (name.ends_with(".nrrd") || name.ends_with(".nhdr")) return read_nrrd(content, file);
  return read_nifti(content, file.string());
}

bool is_compressed(std::string_view data) {
  return data.size() > 2 && data[0] == '\x1f' && data[1] == '\x8b';
}

#ifdef FOREFEEL_ZLIB

namespace {

struct Stream {
  z_stream z{};
  bool good = false;
  Stream() { good = inflateInit2(&z, 15 + 32) == Z_OK; }  // 32: gzip or zlib, by the header
  ~Stream() { inflateEnd(&z); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
};

}  // namespace

std::string inflate(std::string_view data, std::size_t bytes, const std::string& file) {
  Stream stream;
  std::string result;
  std::array<char, 1 << 16> part;
  std::size_t given = 0;
  while (stream.good && result.size() < bytes) {
    if (stream.z.avail_in == 0 && given < data.size()) {
      const std::size_t more = std::min<std::size_t>(data.size() - given, 1u << 30);
      stream.z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data() + given));
      stream.z.avail_in = static_cast<uInt>(more);
      given += more;
    }
    stream.z.next_out = reinterpret_cast<Bytef*>(part.data());
    stream.z.avail_out = static_cast<uInt>(part.size());
    const int code = ::inflate(&stream.z, Z_NO_FLUSH);
    const std::size_t made = part.size() - stream.z.avail_out;
    result.append(part.data(), std::min(made, bytes - result.size()));
    if (code == Z_STREAM_END || (code == Z_BUF_ERROR && made == 0)) break;  // its end, or cut short
    if (code != Z_OK && code != Z_BUF_ERROR) throw InputError({.file = file}, "compressed data are damaged");
  }
  return result;
}

#else

std::string inflate(std::string_view, std::size_t, const std::string& file) {
  throw InputError({.file = file}, "its data are compressed, expected plain data (this build has no zlib)");
}

#endif

}  // namespace forefeel
