// Frames in a stream of bytes.
#include "bridge/uart/frame_reader.h"

#include <gtest/gtest.h>

#include "bridge/schema/unlatch_frame.h"
#include "tests/bridge/random_messages.h"

namespace unlatch::test {
namespace {

using bridge::FrameReader;
using Bytes = std::vector<std::uint8_t>;

int draw_below(Random& random, int count) { return static_cast<int>(random() % static_cast<unsigned>(count)); }

constexpr std::uint64_t kSeed = 4801;

// Frames of random messages, numbered from 0.
std::vector<Bytes> build_frames(int count, Random& random) {
  std::vector<Bytes> frames;
  const auto kinds = list_kinds();
  for (int i = 0; i < count; ++i) {
    const auto kind = kinds[static_cast<std::size_t>(draw_below(random, static_cast<int>(kinds.size())))];
    Bytes frame(bridge::kMaxUdpBytes);
    const std::size_t length =
        hil::encode(make_random_message(kind, random), std::span(frame).subspan(bridge::kUdpHeaderBytes));
    frame.resize(bridge::seal_udp_message({.run = 7, .sequence = static_cast<std::uint32_t>(i)}, kind, frame, length));
    frames.push_back(frame);
  }
  return frames;
}

// Reads a stream, in pieces of random length; returns the numbers of the frames that came.
struct Reading {
  std::vector<std::uint32_t> numbers;
  std::int64_t gaps;
};
Reading read(const Bytes& stream, Random& random, int most) {
  Reading reading{};
  FrameReader reader([&](const bridge::UdpPacket& packet) { reading.numbers.push_back(packet.header.sequence); });
  for (std::size_t at = 0; at < stream.size();) {
    const std::size_t count = std::min(stream.size() - at, static_cast<std::size_t>(1 + draw_below(random, most)));
    reader.push(std::span(stream).subspan(at, count));
    at += count;
  }
  reader.give_up();
  reading.gaps = reader.get_gaps();
  return reading;
}

Bytes join(const std::vector<Bytes>& frames) {
  Bytes stream;
  for (const Bytes& frame : frames) stream.insert(stream.end(), frame.begin(), frame.end());
  return stream;
}

Bytes draw_noise(Random& random) {
  Bytes noise(static_cast<std::size_t>(1 + draw_below(random, 300)));
  for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(draw_below(random, 256));
  // Beginnings of frames, whole or cut, some with a length that leads far behind them.
  if (draw_below(random, 2) == 0) {
    const Bytes begin{'U', 'N', 'L', '1', 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0x0f, 0xff};
    noise.insert(noise.end(), begin.begin(), begin.begin() + 1 + draw_below(random, static_cast<int>(begin.size())));
  }
  return noise;
}

TEST(FrameReader, ReadsAllFramesWhateverThePieces) {
  Random random(kSeed);
  const std::vector<Bytes> frames = build_frames(200, random);
  for (const int most : {1, 3, 64, 5000}) {
    const Reading reading = read(join(frames), random, most);
    ASSERT_EQ(reading.numbers.size(), frames.size()) << "seed " << kSeed;
    for (std::size_t i = 0; i < frames.size(); ++i) EXPECT_EQ(reading.numbers[i], i);
    EXPECT_EQ(reading.gaps, 0);
  }
}

TEST(FrameReader, LosesNoFrameBehindNoise) {
  Random random(kSeed + 1);
  for (int trial = 0; trial < 50; ++trial) {
    const std::vector<Bytes> frames = build_frames(30, random);
    Bytes stream;
    for (const Bytes& frame : frames) {
      const Bytes noise = draw_noise(random);
      stream.insert(stream.end(), noise.begin(), noise.end());
      stream.insert(stream.end(), frame.begin(), frame.end());
    }
    const Reading reading = read(stream, random, 200);
    ASSERT_EQ(reading.numbers.size(), frames.size()) << "seed " << kSeed + 1 << ", trial " << trial;
    EXPECT_EQ(reading.gaps, static_cast<std::int64_t>(frames.size()));
  }
}

TEST(FrameReader, LosesOnlyTheFrameInWhichABitIsWrong) {
  Random random(kSeed + 2);
  const std::vector<Bytes> frames = build_frames(3, random);
  for (int trial = 0; trial < 500; ++trial) {
    std::vector<Bytes> wrong = frames;
    Bytes& middle = wrong[1];
    middle[static_cast<std::size_t>(draw_below(random, static_cast<int>(middle.size())))] ^=
        static_cast<std::uint8_t>(1 << draw_below(random, 8));
    const Reading reading = read(join(wrong), random, 100);
    EXPECT_EQ(reading.numbers, (std::vector<std::uint32_t>{0, 2})) << "seed " << kSeed + 2 << ", trial " << trial;
    EXPECT_EQ(reading.gaps, 1);
  }
}

TEST(FrameReader, LosesOnlyTheFrameInWhichAByteIsMissing) {
  Random random(kSeed + 3);
  const std::vector<Bytes> frames = build_frames(3, random);
  for (int trial = 0; trial < 500; ++trial) {
    std::vector<Bytes> wrong = frames;
    Bytes& middle = wrong[1];
    middle.erase(middle.begin() + draw_below(random, static_cast<int>(middle.size())));
    const Reading reading = read(join(wrong), random, 100);
    EXPECT_EQ(reading.numbers, (std::vector<std::uint32_t>{0, 2})) << "seed " << kSeed + 3 << ", trial " << trial;
  }
}

// bridge/schema/unlatch_frame.h, which programs on boards read with.
TEST(FrameReader, ReadsWhatTheReaderInC99Reads) {
  static_assert(UNLATCH_FRAME_LONGEST == bridge::kMaxUdpBytes);
  static_assert(UNLATCH_FRAME_LAST_KIND == hil::kMessageKinds);
  Random random(kSeed + 4);
  for (int trial = 0; trial < 50; ++trial) {
    Bytes stream;
    for (Bytes& frame : build_frames(20, random)) {
      if (draw_below(random, 3) == 0)
        frame[static_cast<std::size_t>(draw_below(random, static_cast<int>(frame.size())))] ^= 1;
      const Bytes noise = draw_below(random, 3) == 0 ? draw_noise(random) : Bytes{};
      stream.insert(stream.end(), noise.begin(), noise.end());
      stream.insert(stream.end(), frame.begin(), frame.end());
    }
    std::vector<std::uint32_t> numbers;
    unlatch_frame_stream reader{};
    unlatch_frame_order order{};
    unlatch_frame frame;
    const auto read_all = [&] {
      while (unlatch_frame_next(&reader, &frame) != 0) {
        numbers.push_back(frame.sequence);
        EXPECT_EQ(frame.run, 7u);
        EXPECT_NE(unlatch_frame_is_new(&order, &frame), 0);
        EXPECT_EQ(unlatch_frame_is_new(&order, &frame), 0);
      }
    };
    for (const std::uint8_t byte : stream) {
      unlatch_frame_push(&reader, byte);
      read_all();
    }
    while (unlatch_frame_give_up(&reader) != 0) read_all();
    const Reading reading = read(stream, random, 200);
    EXPECT_EQ(numbers, reading.numbers) << "seed " << kSeed + 4 << ", trial " << trial;
    EXPECT_EQ(reader.gaps, reading.gaps);
  }
}

}  // namespace
}  // namespace unlatch::test
