#include "bridge/telemetry/live_server.h"

#include <algorithm>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "bridge/telemetry/send_queue.h"

namespace unlatch::bridge {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using Error = boost::system::error_code;
using Json = nlohmann::json;

constexpr const char* kSubprotocol = "foxglove.websocket.v1";
constexpr std::size_t kMostClients = 8;
constexpr std::size_t kMostSubscriptions = 4096;            // of one client
constexpr std::size_t kMostMessage = std::size_t{1} << 16;  // bytes of what a client sends
constexpr std::uint32_t kMostHeader = 8192;                 // bytes of its request
constexpr auto kHandshake = std::chrono::seconds(5);
constexpr auto kPause = std::chrono::milliseconds(100);  // before the next client where none can be accepted
constexpr char kMessageData = 1;                         // opcode of the protocol

std::string dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

template <class Number>
void put_little_endian(std::string& to, Number number) {
  for (std::size_t i = 0; i < sizeof number; ++i) to += static_cast<char>(number >> (8 * i));
}

bool lists_token(std::string_view list, std::string_view token) {
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(','), list.size());
    std::string_view item = list.substr(0, end);
    while (!item.empty() && item.front() == ' ') item.remove_prefix(1);
    while (!item.empty() && item.back() == ' ') item.remove_suffix(1);
    if (item == token) return true;
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return false;
}

}  // namespace

// --- One client -----------------------------------------------------------------------------------------------------

class LiveServer::Client : public std::enable_shared_from_this<Client> {
 public:
  Client(LiveServer& server, tcp::socket socket) : server_(server), socket_(std::move(socket)) {}

  void start() {
    Error ignored;
    beast::get_lowest_layer(socket_).socket().set_option(tcp::no_delay(true), ignored);
    parser_.header_limit(kMostHeader);
    parser_.body_limit(0);
    beast::get_lowest_layer(socket_).expires_after(kHandshake);
    http::async_read(socket_.next_layer(), buffer_, parser_,
                     [self = shared_from_this()](const Error& error, std::size_t) {
                       if (error) return self->close();
                       self->answer();
                     });
  }

  void send_text(std::string text) {
    // A topic list that finds no place: the client would take later messages for others.
    if (!push({std::make_shared<const std::string>(std::move(text)), true})) close();
  }
  void forget_subscriptions() { subscriptions_.clear(); }
  void send_data(std::size_t topic, std::int64_t time_ns, const std::string& json) {
    const auto [first, last] = subscriptions_.equal_range(topic);
    for (auto one = first; one != last; ++one) {
      std::string bytes(1, kMessageData);
      put_little_endian(bytes, one->second);
      put_little_endian(bytes, static_cast<std::uint64_t>(time_ns));
      bytes += json;
      push({std::make_shared<const std::string>(std::move(bytes)), false});
    }
  }
  [[nodiscard]] bool subscribes(std::size_t topic) const { return subscriptions_.contains(topic); }
  [[nodiscard]] bool is_open() const { return open_; }
  [[nodiscard]] bool is_ready() const { return open_ && ready_; }
  [[nodiscard]] OutletCounts get_counts() const { return {.sent = sent_, .dropped = queue_.get_dropped()}; }

  void close() {
    Error ignored;
    beast::get_lowest_layer(socket_).socket().close(ignored);
    open_ = false;
  }

 private:
  // The request is there: a WebSocket of the right kind and origin, or an answer in words.
  void answer() {
    const auto& request = parser_.get();
    const bool speaks = websocket::is_upgrade(request) &&
                        lists_token(to_view(request[http::field::sec_websocket_protocol]), kSubprotocol);
    const bool welcome = server_.is_welcome(to_view(request[http::field::origin]));
    if (!speaks || !welcome) {
      ++server_.counts_.refused;
      return refuse(welcome
                        ? "This is a WebSocket of the Foxglove protocol, foxglove.websocket.v1: open it in Foxglove, "
                          "or with a client of that subprotocol.\n"
                        : "Pages of this origin may not connect; name it with --origin.\n",
                    welcome ? http::status::upgrade_required : http::status::forbidden);
    }
    beast::get_lowest_layer(socket_).expires_never();  // the WebSocket has timeouts and pings of its own
    socket_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
    socket_.set_option(websocket::stream_base::decorator(
        [](websocket::response_type& response) { response.set(http::field::sec_websocket_protocol, kSubprotocol); }));
    socket_.read_message_max(kMostMessage);
    socket_.async_accept(request, [self = shared_from_this()](const Error& error) {
      if (error) return self->close();
      self->ready_ = true;
      self->send_text(self->server_.write_server_info());
      if (self->server_.topics_) self->send_text(self->server_.write_topics());
      self->read();
    });
  }

  void refuse(const char* text, http::status status) {
    auto response = std::make_shared<http::response<http::string_body>>(status, 11);
    response->set(http::field::content_type, "text/plain; charset=utf-8");
    if (status == http::status::upgrade_required) response->set(http::field::upgrade, "websocket");
    response->body() = text;
    response->keep_alive(false);
    response->prepare_payload();
    http::async_write(socket_.next_layer(), *response,
                      [self = shared_from_this(), response](const Error&, std::size_t) { self->close(); });
  }

  bool push(Outgoing item) {
    if (!is_ready()) return true;
    const bool idle = queue_.is_empty();
    if (!queue_.push(std::move(item))) return false;
    if (idle) write();
    return true;
  }
  void write() {
    socket_.text(queue_.front().is_text);
    socket_.async_write(asio::buffer(*queue_.front().bytes),
                        [self = shared_from_this()](const Error& error, std::size_t) {
                          if (error) return self->close();
                          self->queue_.pop();
                          ++self->sent_;
                          if (!self->queue_.is_empty()) self->write();
                        });
  }
  void read() {
    buffer_.clear();
    socket_.async_read(buffer_, [self = shared_from_this()](const Error& error, std::size_t) {
      if (error) return self->close();
      if (self->socket_.got_text()) self->hear(beast::buffers_to_string(self->buffer_.data()));
      self->read();
    });
  }

  // Subscriptions; all else is ignored.
  void hear(const std::string& text) {
    const Json message = Json::parse(text, nullptr, false);
    if (!message.is_object()) return;
    const auto get_list = [&](const char* key) {
      const auto found = message.find(key);
      return found != message.end() && found->is_array() ? *found : Json::array();
    };
    const auto get_number = [](const Json& from, const char* key) -> std::optional<std::uint32_t> {
      if (!from.is_object()) return std::nullopt;
      const auto found = from.find(key);
      if (found == from.end() || !found->is_number_unsigned()) return std::nullopt;
      const auto number = found->get<std::uint64_t>();
      return number <= std::numeric_limits<std::uint32_t>::max() ? std::optional(static_cast<std::uint32_t>(number))
                                                                 : std::nullopt;
    };
    const auto op = message.find("op");
    if (op == message.end() || !op->is_string()) return;
    if (*op == "subscribe") {
      for (const Json& one : get_list("subscriptions")) {
        const auto id = get_number(one, "id"), topic = get_number(one, "channelId");
        const std::size_t known = server_.topics_ ? server_.topics_->list().size() : 0;
        if (id && topic && *topic < known && subscriptions_.size() < kMostSubscriptions)
          subscriptions_.emplace(*topic, *id);
      }
    } else if (*op == "unsubscribe") {
      for (const Json& id : get_list("subscriptionIds"))
        if (id.is_number_unsigned())
          std::erase_if(subscriptions_, [&](const auto& one) { return one.second == id.get<std::uint64_t>(); });
    }
  }

  static std::string_view to_view(beast::string_view text) { return {text.data(), text.size()}; }

  LiveServer& server_;
  websocket::stream<beast::tcp_stream> socket_;
  http::request_parser<http::empty_body> parser_;
  beast::flat_buffer buffer_{kMostMessage};
  SendQueue queue_;
  std::multimap<std::size_t, std::uint32_t> subscriptions_;  // topic, number of the subscription
  std::int64_t sent_ = 0;
  bool open_ = true, ready_ = false;
};

// --- All of them ----------------------------------------------------------------------------------------------------

LiveServer::LiveServer(asio::io_context& io, const std::string& address, std::vector<std::string> origins)
    : io_(io), origins_(std::move(origins)), acceptor_(listen_at(io, address)) {
  accept();
}

LiveServer::~LiveServer() {
  for (const auto& client : clients_) client->close();
}

// A page of this machine, of a file, or of Foxglove; or no page at all. What follows the host may be a port alone.
bool LiveServer::is_welcome(std::string_view origin) const {
  if (origin.empty() || origin == "file://" || std::ranges::find(origins_, origin) != origins_.end()) return true;
  for (const std::string_view own : {"http://127.0.0.1", "http://localhost", "http://[::1]", "https://localhost",
                                     "https://app.foxglove.dev", "https://studio.foxglove.dev"}) {
    if (!origin.starts_with(own)) continue;
    const std::string_view rest = origin.substr(own.size());
    if (rest.empty() || (rest[0] == ':' && rest.find_first_not_of("0123456789", 1) == std::string_view::npos))
      return true;
  }
  return false;
}

void LiveServer::accept() {
  acceptor_.async_accept([this](const Error& error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (error) {  // no descriptors left, for example: again in a while
      const auto timer = std::make_shared<asio::steady_timer>(io_, kPause);
      return timer->async_wait([this, timer](const Error&) { accept(); });
    }
    remove_closed();
    if (clients_.size() >= kMostClients) {
      ++counts_.refused;  // the socket closes with its last reference
    } else {
      clients_.push_back(std::make_shared<Client>(*this, std::move(socket)));
      clients_.back()->start();
    }
    accept();
  });
}

void LiveServer::remove_closed() {
  std::erase_if(clients_, [this](const std::shared_ptr<Client>& client) {
    if (!client->is_open()) counts_.add(client->get_counts());
    return !client->is_open();
  });
}

std::string LiveServer::write_server_info() const {
  return dump({{"op", "serverInfo"},
               {"name", "unlatch" + (scenario_.empty() ? "" : ": " + scenario_)},
               {"capabilities", Json::array()},
               {"supportedEncodings", {"json"}},
               {"metadata", {{"scenario", scenario_}}},
               {"sessionId", session_}});
}

std::string LiveServer::write_topics() const {
  Json channels = Json::array();
  for (std::size_t i = 0; i < topics_->list().size(); ++i) {
    const LiveTopic& topic = topics_->list()[i];
    channels.push_back({{"id", i},
                        {"topic", topic.name},
                        {"encoding", "json"},
                        {"schemaName", topic.schema_name},
                        {"schema", topic.schema},
                        {"schemaEncoding", "jsonschema"}});
  }
  return dump({{"op", "advertise"}, {"channels", channels}});
}

void LiveServer::begin(const SessionLayout& layout) {
  Json gone = Json::array();
  if (topics_)
    for (std::size_t i = 0; i < topics_->list().size(); ++i) gone.push_back(i);
  topics_.emplace(layout);
  scenario_ = layout.get_scenario();
  session_ = std::to_string(layout.get_session());
  for (const auto& client : clients_) {
    if (!client->is_ready()) continue;
    client->forget_subscriptions();
    if (!gone.empty()) client->send_text(dump({{"op", "unadvertise"}, {"channelIds", gone}}));
    client->send_text(write_server_info());
    client->send_text(write_topics());
  }
}

void LiveServer::send(const hil::Message& message) {
  if (!topics_) return;
  texts_.clear();
  topics_->write(
      message,
      [&](std::size_t topic) {
        return std::ranges::any_of(clients_, [&](const auto& client) { return client->subscribes(topic); });
      },
      texts_);
  for (const LiveTopics::Text& text : texts_)
    for (const auto& client : clients_) client->send_data(text.topic, topics_->get_time(), text.json);
}

OutletCounts LiveServer::get_counts() const {
  OutletCounts counts = counts_;
  for (const auto& client : clients_) {
    counts.add(client->get_counts());
    counts.clients += client->is_ready() ? 1 : 0;
  }
  return counts;
}

}  // namespace unlatch::bridge
