#include "bridge/telemetry/packet_outlet.h"

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/write.hpp>
#include <chrono>

namespace unlatch::bridge {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::ip::udp;
using Error = boost::system::error_code;

constexpr std::size_t kMostClients = 8;
constexpr auto kPause = std::chrono::milliseconds(100);  // before the next client where none can be accepted

}  // namespace

class PacketOutlet::Client : public std::enable_shared_from_this<Client> {
 public:
  explicit Client(tcp::socket socket) : socket_(std::move(socket)) {}

  void start() {
    Error ignored;
    socket_.set_option(tcp::no_delay(true), ignored);
    read();
  }
  void send(const std::shared_ptr<const std::string>& bytes) {
    const bool idle = queue_.is_empty();
    if (queue_.push({bytes}) && idle) write();
  }
  void close() {
    Error ignored;
    socket_.close(ignored);
    open_ = false;
  }
  [[nodiscard]] bool is_open() const { return open_; }
  [[nodiscard]] OutletCounts get_counts() const { return {.sent = sent_, .dropped = queue_.get_dropped()}; }

 private:
  void write() {
    asio::async_write(socket_, asio::buffer(*queue_.front().bytes),
                      [self = shared_from_this()](const Error& error, std::size_t) {
                        if (error) return self->close();
                        self->queue_.pop();
                        ++self->sent_;
                        if (!self->queue_.is_empty()) self->write();
                      });
  }
  void read() {
    socket_.async_read_some(asio::buffer(unread_), [self = shared_from_this()](const Error& error, std::size_t) {
      if (error) return self->close();
      self->read();
    });
  }

  tcp::socket socket_;
  SendQueue queue_;
  std::array<char, 4096> unread_{};
  std::int64_t sent_ = 0;
  bool open_ = true;
};

PacketOutlet::PacketOutlet(asio::io_context& io, const std::string& udp_address, const std::string& tcp_address)
    : io_(io) {
  if (!udp_address.empty()) {
    const Endpoint to = parse_endpoint(udp_address);
    destination_ = udp::endpoint(to.address, to.port);
    Error error;
    datagrams_.emplace(io);
    if (datagrams_->open(destination_.protocol(), error) || datagrams_->non_blocking(true, error))
      throw PortError(udp_address + " cannot be sent to: " + error.message());
  }
  if (!tcp_address.empty()) {
    acceptor_.emplace(listen_at(io, tcp_address));
    accept();
  }
}

PacketOutlet::~PacketOutlet() {
  for (const auto& client : clients_) client->close();
}

void PacketOutlet::accept() {
  acceptor_->async_accept([this](const Error& error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (error) {  // no descriptors left, for example: again in a while
      const auto timer = std::make_shared<asio::steady_timer>(io_, kPause);
      return timer->async_wait([this, timer](const Error&) { accept(); });
    }
    remove_closed();
    if (clients_.size() >= kMostClients) {
      ++counts_.refused;  // the socket closes with its last reference
    } else {
      clients_.push_back(std::make_shared<Client>(std::move(socket)));
      clients_.back()->start();
    }
    accept();
  });
}

void PacketOutlet::send(std::string bytes) {
  if (datagrams_) {
    Error error;
    datagrams_->send_to(asio::buffer(bytes), destination_, 0, error);
    // Nobody listens there, of which a socket reports at its next use: that is no loss of ours.
    if (error && error != asio::error::connection_refused)
      ++counts_.dropped;
    else
      ++counts_.sent;
  }
  if (clients_.empty()) return;
  const auto shared = std::make_shared<const std::string>(std::move(bytes));
  remove_closed();
  for (const auto& client : clients_) client->send(shared);
}

void PacketOutlet::remove_closed() {
  std::erase_if(clients_, [this](const std::shared_ptr<Client>& client) {
    if (!client->is_open()) counts_.add(client->get_counts());
    return !client->is_open();
  });
}

OutletCounts PacketOutlet::get_counts() const {
  OutletCounts counts = counts_;
  for (const auto& client : clients_) {
    counts.add(client->get_counts());
    counts.clients += client->is_open() ? 1 : 0;
  }
  return counts;
}

}  // namespace unlatch::bridge
