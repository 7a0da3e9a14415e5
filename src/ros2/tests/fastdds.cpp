// A participant of Fast DDS, moved by peer.py: fastdds DOMAIN (shm|udp). Frames on standard input make writers and readers and send, frames on standard output
// say who listens and what came. A frame is a letter, a topic's number and a length (u32 of this machine), and that many bytes:
//   in  w, r  a writer or reader: reliable and latched ('0' or '1' each), depth and a blank, the topic and a blank, the type
//       m     a message to send, with the four bytes of its representation
//   out w     a writer's listeners, in digits
//       m     a message that came
// `shm`: shared memory beside UDP, as Fast DDS has it where nobody says otherwise. It is alone with this machine either way.
#include <cstdio>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <map>
#include <mutex>
#include <sstream>
#include <string>

using namespace eprosima::fastdds::dds;
using namespace eprosima::fastdds::rtps;
using eprosima::fastrtps::rtps::IPLocator;
using eprosima::fastrtps::rtps::InstanceHandle_t;
using eprosima::fastrtps::rtps::Locator_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;

// Any keyless type as its bytes: whoever asked for it has made them.
struct Bytes : TopicDataType {
    explicit Bytes(const std::string &name) {
        setName(name.c_str());
        m_typeSize = 1024;
        m_isGetKeyDefined = false;
        auto_fill_type_object(false);
        auto_fill_type_information(false);
    }
    bool serialize(void *data, SerializedPayload_t *payload) override {
        const auto &bytes = *static_cast<std::string *>(data);
        memcpy(payload->data, bytes.data(), bytes.size());
        payload->length = static_cast<uint32_t>(bytes.size());
        payload->encapsulation = CDR_LE;
        return true;
    }
    bool deserialize(SerializedPayload_t *payload, void *data) override {
        static_cast<std::string *>(data)->assign(reinterpret_cast<char *>(payload->data), payload->length);
        return true;
    }
    std::function<uint32_t()> getSerializedSizeProvider(void *data) override {
        return [data] { return static_cast<uint32_t>(static_cast<std::string *>(data)->size()); };
    }
    void *createData() override { return new std::string; }
    void deleteData(void *data) override { delete static_cast<std::string *>(data); }
    bool getKey(void *, InstanceHandle_t *, bool) override { return false; }
};

static void say(char what, uint32_t topic, const std::string &bytes) {
    static std::mutex one;
    std::lock_guard<std::mutex> alone(one);
    const uint32_t head[2] = {topic, static_cast<uint32_t>(bytes.size())};
    fputc(what, stdout);
    fwrite(head, sizeof head, 1, stdout);
    fwrite(bytes.data(), 1, bytes.size(), stdout);
    fflush(stdout);
}

struct Listeners : DataWriterListener {
    uint32_t topic;
    explicit Listeners(uint32_t topic) : topic(topic) {}
    void on_publication_matched(DataWriter *, const PublicationMatchedStatus &status) override { say('w', topic, std::to_string(status.current_count)); }
};

struct Came : DataReaderListener {
    uint32_t topic;
    explicit Came(uint32_t topic) : topic(topic) {}
    void on_data_available(DataReader *reader) override {
        std::string bytes;
        SampleInfo info;
        while (reader->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK)
            if (info.valid_data) say('m', topic, bytes);
    }
};

static int fail(const char *what) {
    fprintf(stderr, "fastdds: %s\n", what);
    return 1;
}

// What writers and readers are asked for alike, as rmw_fastrtps asks for it.
template <class Qos> static Qos asked(Qos qos, bool reliable, bool latched, int depth) {
    qos.reliability().kind = reliable ? RELIABLE_RELIABILITY_QOS : BEST_EFFORT_RELIABILITY_QOS;
    qos.durability().kind = latched ? TRANSIENT_LOCAL_DURABILITY_QOS : VOLATILE_DURABILITY_QOS;
    qos.history().depth = depth;
    qos.resource_limits().max_samples = qos.resource_limits().max_samples_per_instance = depth;
    qos.resource_limits().allocated_samples = 0;
    qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return qos;
}

int main(int argc, char **argv) {
    if (argc != 3) return fail("fastdds DOMAIN (shm|udp)");
    DomainParticipantQos qos;
    qos.transport().use_builtin_transports = false;
    if (!strcmp(argv[2], "shm")) qos.transport().user_transports.push_back(std::make_shared<SharedMemTransportDescriptor>());
    auto udp = std::make_shared<UDPv4TransportDescriptor>();
    udp->interfaceWhiteList.push_back("127.0.0.1");
    qos.transport().user_transports.push_back(udp);
    Locator_t here;
    IPLocator::setIPv4(here, "127.0.0.1");
    qos.wire_protocol().builtin.initialPeersList.push_back(here);
    auto *participant = DomainParticipantFactory::get_instance()->create_participant(static_cast<uint32_t>(atoi(argv[1])), qos);
    if (!participant) return fail("no participant");
    auto *publisher = participant->create_publisher(PUBLISHER_QOS_DEFAULT);
    auto *subscriber = participant->create_subscriber(SUBSCRIBER_QOS_DEFAULT);

    std::map<uint32_t, DataWriter *> writers;
    uint32_t head[2];
    for (int what; (what = getchar()) != EOF && fread(head, sizeof head, 1, stdin) == 1;) {
        std::string bytes(head[1], '\0');
        if (fread(&bytes[0], 1, bytes.size(), stdin) != bytes.size()) return fail("half a frame");
        if (what == 'm') {
            if (!writers.at(head[0])->write(&bytes)) return fail("a message could not be sent");
            continue;
        }
        std::istringstream words(bytes.substr(2));
        int depth;
        std::string name, type;
        words >> depth >> name >> type;
        TypeSupport(new Bytes(type)).register_type(participant);
        auto *topic = participant->create_topic(name, type, TOPIC_QOS_DEFAULT);
        const bool reliable = bytes[0] == '1', latched = bytes[1] == '1';
        if (what == 'w') {
            auto *writer = publisher->create_datawriter(topic, asked(DATAWRITER_QOS_DEFAULT, reliable, latched, depth), new Listeners(head[0]));
            if (!writer) return fail("no writer");
            writers[head[0]] = writer;
        } else if (!subscriber->create_datareader(topic, asked(DATAREADER_QOS_DEFAULT, reliable, latched, depth), new Came(head[0]))) {
            return fail("no reader");
        }
    }
    participant->delete_contained_entities();
    DomainParticipantFactory::get_instance()->delete_participant(participant);
}
