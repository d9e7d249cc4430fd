// Forwards RTP to viewers over WebRTC, with pion: what comes to a UDP port goes to every viewer.
//
// It is asked by lines of JSON on its standard input and answers on its standard output: {"offer": 3} gives the offer
// for viewer 3, {"answer": 3, "sdp": "..."} takes its answer in. With the end of its input it ends.
package main

import (
	"bufio"
	"encoding/json"
	"fmt"
	"net"
	"os"

	"github.com/pion/webrtc"
)

type request struct {
	Offer  *int   `json:"offer"`
	Answer *int   `json:"answer"`
	SDP    string `json:"sdp"`
}

func check(err error) {
	if err != nil {
		fmt.Fprintln(os.Stderr, err)
		os.Exit(1)
	}
}

// forward hands what comes to the port on to the track, without looking into it more than the track does.
func forward(socket *net.UDPConn, track *webrtc.TrackLocalStaticRTP) {
	packet := make([]byte, 1600)
	for {
		length, err := socket.Read(packet)
		check(err)
		_, err = track.Write(packet[:length])
		check(err)
	}
}

// drain reads what the viewer reports, without which the interceptors would not see it.
func drain(sender *webrtc.RTPSender) {
	packet := make([]byte, 1600)
	for {
		if _, _, err := sender.Read(packet); err != nil {
			return
		}
	}
}

func offer(track *webrtc.TrackLocalStaticRTP) (*webrtc.PeerConnection, string) {
	connection, err := webrtc.NewPeerConnection(webrtc.Configuration{})
	check(err)
	sender, err := connection.AddTrack(track)
	check(err)
	go drain(sender)
	description, err := connection.CreateOffer(nil)
	check(err)
	gathered := webrtc.GatheringCompletePromise(connection)
	check(connection.SetLocalDescription(description))
	<-gathered
	return connection, connection.LocalDescription().SDP
}

func main() {
	address, err := net.ResolveUDPAddr("udp4", "127.0.0.1:"+os.Args[1])
	check(err)
	socket, err := net.ListenUDP("udp4", address)
	check(err)
	capability := webrtc.RTPCodecCapability{
		MimeType: webrtc.MimeTypeH264, ClockRate: 90000,
		SDPFmtpLine: "level-asymmetry-allowed=1;packetization-mode=1;profile-level-id=42e01f",
	}
	track, err := webrtc.NewTrackLocalStaticRTP(capability, "video", "peers")
	check(err)
	go forward(socket, track)
	connections := map[int]*webrtc.PeerConnection{}
	lines := bufio.NewScanner(os.Stdin)
	lines.Buffer(nil, 1<<20)
	answers := json.NewEncoder(os.Stdout)
	for lines.Scan() {
		var asked request
		check(json.Unmarshal(lines.Bytes(), &asked))
		if asked.Offer != nil {
			connection, sdp := offer(track)
			connections[*asked.Offer] = connection
			check(answers.Encode(map[string]string{"sdp": sdp}))
			continue
		}
		answer := webrtc.SessionDescription{Type: webrtc.SDPTypeAnswer, SDP: asked.SDP}
		check(connections[*asked.Answer].SetRemoteDescription(answer))
		check(answers.Encode(map[string]string{}))
	}
}
