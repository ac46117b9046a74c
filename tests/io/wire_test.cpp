#include "io/wire.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <numeric>
#include <vector>

#include "twin.pb.h"

namespace lamella {
namespace {

TEST(Socket, GivesTheBytesThatCameTogetherWithAMessageAndThoseAfterThem) {
  int ends[2];
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  Socket near(ends[0]), far(ends[1]);
  const Deadline deadline = deadline_in(10);
  v1::PhotographHeader header;
  header.set_size_bytes(1000);
  std::vector<uint8_t> sent(1000), got(1000);
  std::iota(sent.begin(), sent.end(), uint8_t{0});
  ASSERT_FALSE(far.send(header, deadline));
  ASSERT_FALSE(far.send_bytes(sent.data(), 600, deadline));
  // All that has come by now is read with the header.
  v1::PhotographHeader read;
  ASSERT_FALSE(near.receive(&read, deadline));
  ASSERT_FALSE(far.send_bytes(sent.data() + 600, 400, deadline));
  ASSERT_FALSE(near.receive_bytes(got.data(), got.size(), deadline));
  EXPECT_EQ(got, sent);
  ASSERT_FALSE(far.send(header, deadline));
  EXPECT_FALSE(near.receive(&read, deadline)) << "the next message begins where the bytes end";
}

}  // namespace
}  // namespace lamella
