// Output of avahi-browse 0.8 about servers whose names and TXT records were chosen to harm.
#include "discovery/announced.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "say.hpp"

namespace haptic::ctl {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Announced, AServerWithItsTexts) {
  const auto server =
      announced(R"(=;eth0;IPv4;hapticd\032on\032lab;_hapticd._tcp;local;lab.local;192.0.2.7;29470;)"
                R"("page=29473" "protocol=haptic.v1")");
  ASSERT_TRUE(server);
  EXPECT_EQ(server->name, "hapticd on lab");
  EXPECT_EQ(server->host, "lab.local");
  EXPECT_EQ(server->address, "192.0.2.7:29470");
  EXPECT_THAT(server->txt, ElementsAre("page=29473", "protocol=haptic.v1"));
}

TEST(Announced, LinkLocalAddressesKeepTheirInterface) {
  const std::string end = ";29470;";
  const std::string begin = "=;eth0;IPv6;a;_hapticd._tcp;local;lab.local;";
  EXPECT_EQ(announced(begin + "fe80::1" + end)->address, "[fe80::1%eth0]:29470");
  EXPECT_EQ(announced(begin + "2001:db8::1" + end)->address, "[2001:db8::1]:29470");
}

TEST(Announced, HostileBytesStayOneServer) {
  const auto server = announced(
      R"(=;lo;IPv4;evil\027\0912J\059x\034\010S\195\188d;_hapticd._tcp;local;vm.local;127.0.0.1;)"
      R"(29471;"\027[31m\255\254 \"q\" \\ \001" "k=a\010=;lo;IPv4;fake;_hapticd._tcp;local;h")");
  ASSERT_TRUE(server);
  EXPECT_EQ(server->name,
            "evil\x1b[2J;x\"\nS\xc3\xbc"
            "d");
  EXPECT_THAT(server->txt, ElementsAre("\x1b[31m\xff\xfe \"q\" \\ \x01",
                                       "k=a\n=;lo;IPv4;fake;_hapticd._tcp;local;h"));
}

TEST(Announced, WhatIsShownIsPlainAscii) {
  for (int first = 0; first < 256; ++first) {
    const std::string text{static_cast<char>(first), static_cast<char>(0x9B), '\n'};
    for (const char c : dump(text)) EXPECT_TRUE(c >= 0x20 && c < 0x7F) << first;
  }
  EXPECT_EQ(dump("S\xc3\xbc"
                 "d\xe2\x80\xae"),
            R"("S\u00fcd\u202e")");
}

TEST(Announced, OtherLinesAreNoServer) {
  const std::string begin = "=;eth0;IPv4;a;_hapticd._tcp;local;lab.local;";
  EXPECT_TRUE(announced(begin + "192.0.2.7;29470;"));
  for (const char* rest :
       {"192.0.2.7;29470", "192.0.2.7;0;", "192.0.2.7;65536;", "192.0.2.7;-1;", "192.0.2.7;29470x;",
        "192.0.2.7;;", "192.0.2;29470;", "lab.local;29470;", "1;2;", ""}) {
    EXPECT_FALSE(announced(begin + rest)) << rest;
  }
  EXPECT_FALSE(announced("+;eth0;IPv4;a;_hapticd._tcp;local"));
  EXPECT_FALSE(announced("+" + begin.substr(1) + "192.0.2.7;29470;"));
  EXPECT_FALSE(announced(""));
  EXPECT_FALSE(announced(std::string(10, ';')));
}

TEST(Announced, CutTextsEndWithTheLine) {
  const std::string begin = "=;eth0;IPv4;a\\;_hapticd._tcp;local;lab.local;192.0.2.7;29470;";
  for (const char* txt : {"\"", "\"a\\", "\"a\\0", "\"a\\25"}) {
    ASSERT_TRUE(announced(begin + txt)) << txt;
    EXPECT_EQ(announced(begin + txt)->txt.size(), 1U) << txt;
  }
  EXPECT_THAT(announced(begin + "no quotes")->txt, IsEmpty());
}

}  // namespace
}  // namespace haptic::ctl
