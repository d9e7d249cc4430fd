using System;
using System.Linq;
using System.Threading.Tasks;
using OpenRoIS.Components;
using OpenRoIS.Media;
using OpenRoIS.Unity;
using Unity.WebRTC;
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

        private Client _client;
        private MediaSession _media;
        private Body _body;
        private bool _isBusy;
        private bool _isOver;

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
            catch (Exception error)
            {
                // Another application has taken the body, it has failed, or there is no connection.
                Debug.LogWarning(error.Message);
            }
            finally
            {
                _isBusy = false;
            }
        }

        private async void Start()
        {
            try
            {
                _client = await GetComponent<OpenRoISClient>().ConnectedAsync();
            }
            catch (OperationCanceledException)
            {
                return;
            }
            // Unity's WebRTC package decodes pictures in this coroutine.
            StartCoroutine(WebRTC.Update());
            _media = new MediaSession(_client, request => new WebRtcPeer(request, this, Show));
            _client.BodyLost += Lost;
            _client.ConnectionChanged += Changed;
            Reserve();
        }

        private void OnDestroy()
        {
            _isOver = true;
            _media?.Dispose();
            _body?.Dispose();
        }

        private async void Reserve()
        {
            var request = new BodyRequest(SpeechSynthesis.Type)
            {
                Optional = new ComponentType[] { Reaction.Type, VideoStreaming.Type },
                Wait = TimeSpan.FromMinutes(10)
            };
            while (!_isOver && _body == null)
            {
                try
                {
                    Body body = await _client.BodyAsync(request);
                    // What comes when the scene has ended, or is lost already, is given back.
                    _body = _isOver || body.Error != null ? null : body;
                    if (_body == null)
                    {
                        body.Dispose();
                    }
                }
                catch (ConnectionLostException)
                {
                    // The scene has ended, or there will be no connection any more: the client says why.
                    return;
                }
                catch (Exception error) when (error is RoISException || error is TimeoutException)
                {
                    // All bodies are taken, or the gateway is away: it is tried further.
                    Debug.LogWarning(error.Message);
                }
            }
            Watch();
        }

        private async void Watch()
        {
            VideoStreaming video = _body?.Find(VideoStreaming.Type);
            try
            {
                await (video?.ConnectStreamAsync(encoding: new { codecs = new[] { "video/H264", "video/VP8" } })
                    ?? Task.FromResult(""));
            }
            catch (Exception error)
            {
                Debug.LogWarning("no pictures: " + error.Message);
            }
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
            await _client.RunAsync(new Concurrent(speech.StartStep(), reaction.StartStep()));
        }

        private void Lost(BodyLoss loss)
        {
            Debug.LogWarning(loss.EngineId + " is lost: " + loss.Error.Message);
            if (_body?.Error != null)
            {
                _body.Dispose();
                _body = null;
                Reserve();
            }
        }

        private void Changed(ConnectionChange change)
        {
            // Streams end with their connection; the body is kept.
            if (change.State == ConnectionState.Connected)
            {
                Watch();
            }
        }

        private void Show(Texture picture)
        {
            Screen.material.mainTexture = picture;
        }
    }
}
