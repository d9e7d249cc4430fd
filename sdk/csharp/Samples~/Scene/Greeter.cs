using System;
using System.Linq;
using System.Threading.Tasks;
using OpenRoIS.Components;
using OpenRoIS.Media;
using OpenRoIS.Unity;
using UnityEngine;

namespace OpenRoIS.Samples
{
    /// <summary>
    /// Lets a body that is free greet, and shows what its camera sees. Put it on an object with an <see cref="OpenRoISClient"/>,
    /// drag a renderer to <c>Screen</c>, and call <see cref="Greet"/> from a button.
    /// </summary>
    [RequireComponent(typeof(OpenRoISClient))]
    public sealed class Greeter : MonoBehaviour
    {
        [Tooltip("Shows the pictures of the body")]
        public Renderer Screen;

        [Tooltip("What the body says")]
        public string Words = "Hello! I am glad to see you.";

        private MediaSession _media;
        private Body _body;
        private bool _isBusy;

        /// <summary>To be called from a button.</summary>
        public async void Greet()
        {
            if (_isBusy || _body == null)
            {
                return;
            }
            _isBusy = true;
            try
            {
                await GreetAsync(_body);
            }
            catch (RoISException error)
            {
                // Another application has taken the body, or it has failed.
                Debug.LogWarning(error.Message);
            }
            _isBusy = false;
        }

        private async void Start()
        {
            try
            {
                Client client = await GetComponent<OpenRoISClient>().ConnectedAsync();
                client.BodyLost += loss => Debug.LogWarning(loss.EngineId + " is lost: " + loss.Error.Message);
                _media = new MediaSession(client, request => new WebRtcPeer(request, this, Show));
                _body = await client.BodyAsync(new BodyRequest(SpeechSynthesis.Type)
                {
                    Optional = new ComponentType[] { Reaction.Type, VideoStreaming.Type },
                    Wait = TimeSpan.FromMinutes(10)
                });
                await WatchAsync(_body.Find(VideoStreaming.Type));
                // The stream ends with its connection: a lost one is another one's to connect.
                client.ConnectionChanged += change => Again(change, client);
            }
            catch (OperationCanceledException)
            {
                // The scene has ended.
            }
            catch (Exception error)
            {
                Debug.LogException(error);
            }
        }

        private void OnDestroy()
        {
            _media?.Dispose();
            _body?.Dispose();
        }

        private async Task GreetAsync(Body body)
        {
            SpeechSynthesis speech = body.Part(SpeechSynthesis.Type);
            Reaction reaction = body.Find(Reaction.Type);
            await speech.SetAsync(speechText: Words);
            if (reaction == null)
            {
                await speech.StartAsync();
                return;
            }
            await reaction.SetAsync(reactionRef: (await reaction.AvailableReactionsAsync()).First());
            await body.Part(SpeechSynthesis.Type).Client.RunAsync(new Concurrent(speech.StartStep(), reaction.StartStep()));
        }

        private static async Task WatchAsync(VideoStreaming video)
        {
            if (video != null)
            {
                await video.ConnectStreamAsync(encoding: new { codecs = new[] { "video/H264", "video/VP8" } });
            }
        }

        private async void Again(ConnectionChange change, Client client)
        {
            if (change.State != ConnectionState.Connected)
            {
                return;
            }
            try
            {
                await WatchAsync(_body.Find(VideoStreaming.Type));
            }
            catch (Exception error)
            {
                Debug.LogWarning("no pictures: " + error.Message);
            }
        }

        private void Show(Texture picture)
        {
            Screen.material.mainTexture = picture;
        }
    }
}
