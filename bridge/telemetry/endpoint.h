// Addresses of telemetry: "127.0.0.1:10015". Loopback alone, unless another address is named.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <charconv>
#include <string>

#include "bridge/core/port.h"

namespace unlatch::bridge {

struct Endpoint {
  boost::asio::ip::address address;
  std::uint16_t port = 0;
};

inline Endpoint parse_endpoint(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  Endpoint endpoint;
  boost::system::error_code error;
  std::string host = text.substr(0, colon);
  if (host.size() > 1 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  if (host == "localhost") host = "127.0.0.1";
  endpoint.address = boost::asio::ip::make_address(host, error);
  const char* const end = text.data() + text.size();
  if (colon != std::string::npos) {
    const auto [stop, fault] = std::from_chars(text.data() + colon + 1, end, endpoint.port);
    if (fault != std::errc{} || stop != end) endpoint.port = 0;
  }
  if (error || endpoint.port == 0)
    throw PortError("'" + text + "' is no address and port; write it like 127.0.0.1:10015, or [::1]:10015");
  return endpoint;
}

// Opens a listening socket.
inline boost::asio::ip::tcp::acceptor listen_at(boost::asio::io_context& io, const std::string& text) {
  const Endpoint at = parse_endpoint(text);
  try {
    const boost::asio::ip::tcp::endpoint endpoint(at.address, at.port);
    boost::asio::ip::tcp::acceptor acceptor(io, endpoint.protocol());
    acceptor.set_option(boost::asio::socket_base::reuse_address(true));
    acceptor.bind(endpoint);
    acceptor.listen();
    return acceptor;
  } catch (const boost::system::system_error& fault) {
    throw PortError(text + " cannot be opened: " + fault.code().message() + "; choose another port or address");
  }
}

}  // namespace unlatch::bridge
